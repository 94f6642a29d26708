"""Networks, inputs and losses that the ablation compares with ours."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from benchmarks.paper_unet import UNet, combined_loss
from model.features import CHANNELS, Features, network_input
from model.loss import FEW_PIXELS, contact_loss
from model.network import ContactNet, balanced_pressure
from solver.influence import free_coefficients

LOGISTIC = (-1.9, -20.2, 5.2, 8.6), -5.8
"""Weights of the four channels and the bias of a logistic regression on each pixel alone."""

RECTIFIED = (2 / (1 - 1 / torch.pi)) ** 0.5
"""What a ReLU takes from the standard deviation of a normal signal, inverted."""


def ours(logits: Tensor, relative: Tensor, given: Features, pressure: Tensor) -> Tensor:
    """The loss as it is."""
    return contact_loss(logits, relative, pressure, torch.ones(len(pressure)))


def mask_alone(logits: Tensor, relative: Tensor, given: Features, pressure: Tensor) -> Tensor:
    """No error of the pressure."""
    return contact_loss(logits, relative, pressure, torch.zeros(len(pressure)))


def unweighted(logits: Tensor, relative: Tensor, given: Features, pressure: Tensor) -> Tensor:
    """Cross entropy over all pixels of the batch, so that maps with little contact weigh little."""
    mask = (pressure > 0).float()
    usual = mask.sum(dim=(1, 2)).mean() + FEW_PIXELS
    cross_entropy = (
        functional.binary_cross_entropy_with_logits(logits, mask, reduction="none").sum(dim=(1, 2)).mean() / usual
    )
    return cross_entropy + ours(logits, relative, given, pressure) - mask_alone(logits, relative, given, pressure)


def paper_loss(logits: Tensor, relative: Tensor, given: Features, pressure: Tensor) -> Tensor:
    """BCE and Dice on the mask."""
    return combined_loss(logits, (pressure > 0).float())


def with_residual(logits: Tensor, relative: Tensor, given: Features, pressure: Tensor) -> Tensor:
    """The paper's proposed physical constraint: pressure times gap and overlap, of the pressure that carries the load."""
    predicted = balanced_pressure(logits, relative, given.load)
    rows, columns = predicted.shape[1:]
    transform = torch.fft.rfft2(predicted, s=(2 * rows, 2 * columns)) * _spectrum(rows, columns)
    gap = torch.fft.irfft2(transform, s=(2 * rows, 2 * columns))[:, :rows, :columns] - given.heights
    total = predicted.sum(dim=(1, 2))
    approach = (predicted * gap).sum(dim=(1, 2)) / total
    apart = gap - approach[:, None, None]
    broken = (predicted * apart.abs()).sum(dim=(1, 2)) / total
    overlap = apart.clamp_max(0).square().sum(dim=(1, 2)) / ((pressure > 0).sum(dim=(1, 2)) + FEW_PIXELS)
    return ours(logits, relative, given, pressure) + (broken + overlap.sqrt()).mean()


@lru_cache
def _spectrum(rows: int, columns: int) -> Tensor:
    corner = free_coefficients((rows + 1, columns + 1), (1.0, 1.0))
    kernel = np.block([[corner[:rows, :columns], corner[:rows, :0:-1]], [corner[:0:-1, :columns], corner[:0:-1, :0:-1]]])
    return torch.from_numpy(np.fft.rfft2(kernel).real.astype(np.float32))


def heights_and_load(given: Features) -> Tensor:
    """What the paper's network sees."""
    load = given.conditions[:, :1, None]
    heights = given.heights / given.heights.std(dim=(1, 2), keepdim=True)
    return torch.stack([heights, load.expand_as(heights)], dim=1)


def heights_alone(given: Features) -> Tensor:
    """Ours without the coarse solution; the load comes in as ever."""
    return network_input(replace(given, coarse=torch.zeros_like(given.coarse)))


class PaperNet(nn.Module):
    """The paper's U-Net, saying pressures that no one asks for."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.unet = UNet(2, width)

    def forward(self, fields: Tensor, conditions: Tensor) -> Tensor:
        """Logits, twice."""
        logits = self.unet(fields).float()
        return torch.stack([logits, logits], dim=1)


class GuessingNet(ContactNet):
    """Ours, which adds to what a logistic regression makes of each pixel alone."""

    def __init__(self) -> None:
        super().__init__()
        nn.init.zeros_(self.head.bias)  # type: ignore[arg-type]
        self.guess = nn.Conv2d(CHANNELS, 1, 1)
        self.guess.weight.data = torch.tensor(LOGISTIC[0]).view(1, -1, 1, 1)
        self.guess.bias.data.fill_(LOGISTIC[1])  # type: ignore[union-attr]

    def forward(self, fields: Tensor, conditions: Tensor) -> Tensor:
        """As ours."""
        logits, pressures = super().forward(fields, conditions).chunk(2, dim=1)
        return torch.cat([logits + self.guess(fields), pressures], dim=1)


class StandardizedConvolution(nn.Conv2d):
    """A 3 x 3 convolution whose weights have mean zero and a variance that keeps that of a rectified signal.

    Source: Brock, De & Smith 2021, arXiv:2101.08692.
    """

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__(inputs, outputs, 3, padding=1)
        self.gain = nn.Parameter(torch.ones(outputs, 1, 1, 1))

    def forward(self, x: Tensor) -> Tensor:
        """Shape (batch, inputs, rows, columns) to (batch, outputs, rows, columns)."""
        deviation, mean = torch.std_mean(self.weight, dim=(1, 2, 3), keepdim=True, correction=0)
        scale = RECTIFIED / (9 * self.in_channels) ** 0.5
        return functional.conv2d(x, (self.weight - mean) * (scale * self.gain / (deviation + 1e-6)), self.bias, padding=1)


def standardized(network: nn.Module) -> nn.Module:
    """A network with standardized convolutions in the place of those with batch norms."""
    for block in list(network.modules()):
        for name, part in list(block.named_children()):
            if isinstance(part, nn.Conv2d) and part.bias is None:
                setattr(block, name, StandardizedConvolution(part.in_channels, part.out_channels))
            elif isinstance(part, nn.BatchNorm2d):
                setattr(block, name, nn.Identity())
    return network
