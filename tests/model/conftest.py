import pytest
import torch


@pytest.fixture(autouse=True, scope="package")
def one_thread() -> None:
    """Small networks run fastest on one thread, and the same on every machine."""
    torch.set_num_threads(1)
