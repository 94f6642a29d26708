"""The network: a U-Net on half the resolution that predicts contact and pressure.

Every 2 x 2 pixels are one place with four times the channels, which costs a quarter and loses nothing; with 4 x 4 it would
lose much (docs/benchmarks/ablation.md). Load and aspect of the pixels come in as a bias after the first convolution.
"""

from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from model.features import CHANNELS, CONDITIONS

WIDTHS = (32, 64, 96, 128, 192)
"""Feature maps at 1/2, 1/4, ... of the resolution."""

USUAL_LOGIT = -4.0
"""Of contact, where nothing is known yet: most pixels do not touch."""

LEAST_LOGIT, LEAST_PRESSURE = -30.0, 1e-6
"""What counts at least, so that pressures can carry the load even where no pixel touches."""

PLACE = 2
"""Pixels a side of a place."""

MULTIPLE = PLACE * 2 ** (len(WIDTHS) - 1)
"""Rows and columns are padded to a multiple of this."""


def _convolution(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 3, padding=1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU(inplace=True)
    )


def _two_convolutions(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(*_convolution(inputs, outputs), *_convolution(outputs, outputs))


class ContactNet(nn.Module):
    """Contact logits and pressures from features.

    Args:
        widths: feature maps on places, on 2 x 2 of them, and so on.
        place: pixels a side of a place.
    """

    def __init__(self, widths: tuple[int, ...] = WIDTHS, place: int = PLACE) -> None:
        super().__init__()
        self.place, self.multiple = place, place * 2 ** (len(widths) - 1)
        first, last, pixels = widths[0], widths[::-1], place**2
        self.conditions = nn.Linear(CONDITIONS, first)
        self.stem = nn.Sequential(nn.Conv2d(pixels * CHANNELS, first, 3, padding=1, bias=False), nn.BatchNorm2d(first))
        self.contracting = nn.ModuleList(
            [_convolution(first, first)] + [_two_convolutions(inputs, outputs) for inputs, outputs in pairwise(widths)]
        )
        self.narrowing = nn.ModuleList(nn.Conv2d(inputs, outputs, 1) for inputs, outputs in pairwise(last))
        self.expanding = nn.ModuleList(_two_convolutions(outputs, outputs) for outputs in last[1:])
        self.head = nn.Conv2d(first, 2 * pixels, 3, padding=1)
        nn.init.constant_(self.head.bias[:pixels], USUAL_LOGIT)  # type: ignore[index]

    def forward(self, fields: Tensor, conditions: Tensor) -> Tensor:
        """Logits of contact, and pressures.

        Args:
            fields: see :func:`model.features.network_input`, shape (batch, CHANNELS, rows, columns), any rows and columns.
            conditions: shape (batch, CONDITIONS).

        Returns:
            Shape (batch, 2, rows, columns); the pressures are positive and relative.
        """
        rows, columns = fields.shape[-2:]
        padded = functional.pad(fields, (0, -columns % self.multiple, 0, -rows % self.multiple), mode="replicate")
        places = functional.pixel_unshuffle(padded, self.place).contiguous(memory_format=torch.channels_last)
        x = functional.relu(self.stem(places) + self.conditions(conditions)[:, :, None, None], inplace=True)
        skips: list[Tensor] = []
        for level, block in enumerate(self.contracting):
            x = block(functional.max_pool2d(x, 2) if level else x)
            skips.append(x)
        for narrow, block, skip in zip(self.narrowing, self.expanding, skips[-2::-1], strict=True):
            x = block(functional.interpolate(narrow(x), scale_factor=2.0) + skip)
        logits, pressures = functional.pixel_shuffle(self.head(x), self.place)[..., :rows, :columns].float().chunk(2, dim=1)
        return torch.cat([logits, functional.softplus(pressures) + LEAST_PRESSURE], dim=1)

    def fuse(self) -> "ContactNet":
        """For evaluation: merge every batch norm into the convolution before it."""
        self.eval()
        for module in list(self.modules()):
            if isinstance(module, nn.Sequential):
                _merge(module)
        return self


def _merge(block: nn.Sequential) -> None:
    for name, following in zip(list(block._modules), list(block._modules)[1:], strict=False):
        convolution, norm = block._modules[name], block._modules[following]
        if isinstance(convolution, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d):
            block._modules[name], block._modules[following] = fuse_conv_bn_eval(convolution, norm), nn.Identity()


def balanced_pressure(logits: Tensor, relative: Tensor, load: Tensor) -> Tensor:
    """Pressures with the mean that the load asks for.

    Args:
        logits, relative: of the network, shape (batch, rows, columns).
        load: mean pressure, shape (batch,), whose unit the result has.
    """
    pressure = torch.sigmoid(logits.clamp_min(LEAST_LOGIT)) * relative
    return pressure * (load / pressure.mean(dim=(1, 2)))[:, None, None]
