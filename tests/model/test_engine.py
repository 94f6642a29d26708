from concurrent.futures import ThreadPoolExecutor

import pytest
import torch
from torch import Tensor

from model.engine import Engine
from model.features import CHANNELS, CONDITIONS
from model.network import ContactNet


@pytest.fixture(scope="module")
def network() -> ContactNet:
    torch.manual_seed(0)
    return ContactNet().fuse()


@pytest.fixture(scope="module")
def engine(network: ContactNet) -> Engine:
    return Engine(network)


def given(batch: int, rows: int, columns: int) -> tuple[Tensor, Tensor]:
    generator = torch.Generator().manual_seed(rows)
    places = torch.randn(batch, CHANNELS, rows, columns, generator=generator)
    return places, torch.randn(batch, CONDITIONS, generator=generator)


@pytest.mark.parametrize("shape", [(1, 16, 16), (3, 32, 32), (2, 33, 50), (1, 64, 128)])
@torch.inference_mode()
def test_it_says_what_the_network_says(network: ContactNet, engine: Engine, shape: tuple[int, int, int]) -> None:
    ours, reference = engine(*given(*shape)), network(*given(*shape))
    assert ours.shape == reference.shape
    assert (ours - reference).abs().max() < 0.02 * reference.abs().max()


def test_threads_share_it_and_it_says_the_same_again(engine: Engine) -> None:
    shapes = [(1, 8, 16), (2, 20, 20), (1, 33, 7), (1, 8, 16)] * 4
    alone = [engine(*given(*shape)) for shape in shapes]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda shape: engine(*given(*shape)), shapes))
    for ours, reference in zip(together, alone, strict=True):
        assert torch.equal(ours, reference)
