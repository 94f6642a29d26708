"""Loss of the network: cross entropy of the contact mask and error of the pressure, each relative to the map's contact."""

import torch
from torch import Tensor
from torch.nn import functional

from model.network import balanced_pressure

PRESSURE_WEIGHT = 0.5

FEW_PIXELS = 16
"""Pixels in contact below which a map counts less than others."""


def contact_loss(logits: Tensor, relative: Tensor, pressure: Tensor, known: Tensor) -> Tensor:
    """Mean loss over a batch.

    The cross entropy is summed over the pixels and divided by those in contact, so that maps with little contact weigh as
    much as others; unlike a Dice loss it leaves the probabilities, and with them the area, without a bias. The error of the
    pressure is the load that acts in the wrong place, as a share.

    Args:
        logits, relative: of the network, shape (batch, rows, columns).
        pressure: reference, in any unit, zero off contact, same shape.
        known: whether it is more than a mask, shape (batch,).
    """
    mask = (pressure > 0).to(logits.dtype)
    cross_entropy = functional.binary_cross_entropy_with_logits(logits, mask, reduction="none").sum(dim=(1, 2))
    predicted = balanced_pressure(logits, relative, pressure.mean(dim=(1, 2)))
    misplaced = known * (predicted - pressure).abs().sum(dim=(1, 2)) / pressure.sum(dim=(1, 2))
    return torch.mean(cross_entropy / (mask.sum(dim=(1, 2)) + FEW_PIXELS) + PRESSURE_WEIGHT * misplaced)
