import pytest
import torch

from model.features import CHANNELS, CONDITIONS
from model.network import ContactNet, balanced_pressure


def trained_a_little() -> ContactNet:
    """A network whose batch norms have seen something."""
    torch.manual_seed(0)
    network = ContactNet((4, 6, 8))
    for _ in range(3):
        network(torch.randn(4, CHANNELS, 32, 32), torch.randn(4, CONDITIONS))
    return network.eval()


@pytest.mark.parametrize("shape", [(16, 16), (17, 50), (33, 128)])
def test_any_rows_and_columns(shape: tuple[int, int]) -> None:
    network = ContactNet().eval()
    with torch.inference_mode():
        said = network(torch.randn(2, CHANNELS, *shape), torch.randn(2, CONDITIONS))
    assert said.shape == (2, 2, *shape)
    assert (said[:, 1] > 0).all()


@torch.inference_mode()
def test_every_pixel_sees_far_and_its_own_pixel() -> None:
    network = trained_a_little()
    fields, conditions = torch.randn(1, CHANNELS, 96, 96), torch.zeros(1, CONDITIONS)
    changed = fields.clone()
    changed[..., :2, :2] += 5
    difference = (network(fields, conditions) - network(changed, conditions)).abs()[0, 0]
    assert difference[10:, 10:].max() > 0
    assert len(difference[:2, :2].unique()) == 4


@torch.inference_mode()
def test_load_and_aspect_matter() -> None:
    network = trained_a_little()
    fields = torch.randn(1, CHANNELS, 32, 32)
    reference = network(fields, torch.zeros(1, CONDITIONS))
    for i in range(CONDITIONS):
        assert not torch.equal(network(fields, torch.eye(CONDITIONS)[i : i + 1]), reference)


@torch.inference_mode()
def test_merging_batch_norms_changes_nothing() -> None:
    network = trained_a_little()
    fields, conditions = torch.randn(2, CHANNELS, 32, 32), torch.randn(2, CONDITIONS)
    before = network(fields, conditions)
    after = network.fuse()(fields, conditions)
    assert not any(isinstance(module, torch.nn.BatchNorm2d) for module in network.modules())
    torch.testing.assert_close(after, before, rtol=1e-4, atol=1e-5)


def test_the_pressure_carries_the_load() -> None:
    load = torch.tensor([0.01, 2.0, 1e-6])
    pressure = balanced_pressure(torch.randn(3, 20, 30), torch.rand(3, 20, 30), load)
    assert (pressure >= 0).all()
    torch.testing.assert_close(pressure.mean(dim=(1, 2)), load)
