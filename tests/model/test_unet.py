import pytest
import torch
from torch import nn

from model.unet import UNet


def test_the_papers_network_has_23_convolutional_layers_and_four_poolings() -> None:
    network = UNet(channels=1, width=64)
    convolutions = [m for m in network.modules() if isinstance(m, nn.Conv2d | nn.ConvTranspose2d)]
    assert len(convolutions) == 23
    assert sum(isinstance(m, nn.ConvTranspose2d) for m in convolutions) == 4
    assert max(m.out_channels for m in convolutions) == 1024
    assert sum(p.numel() for p in network.parameters()) == pytest.approx(31e6, rel=0.01)


@pytest.mark.parametrize("shape", [(16, 16), (17, 50), (33, 128)])
def test_any_rows_and_columns(shape: tuple[int, int]) -> None:
    network = UNet(channels=4, width=4).eval()
    with torch.inference_mode():
        assert network(torch.randn(2, 4, *shape)).shape == (2, *shape)


def test_every_pixel_sees_far() -> None:
    """Changing one corner changes the answer many pixels away: the receptive field spans the poolings."""
    torch.manual_seed(0)
    network = UNet(channels=1, width=8).eval()
    inputs = torch.randn(1, 1, 96, 96)
    changed = inputs.clone()
    changed[..., :4, :4] += 5
    with torch.inference_mode():
        difference = (network(inputs) - network(changed)).abs()[0]
    assert difference[40:, 40:].max() > 0
