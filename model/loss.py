"""Combined loss of the paper: alpha * BCE + (1 - alpha) * Dice loss (Eqs. 13-16)."""

import torch
from torch import Tensor
from torch.nn import functional


def combined_loss(logits: Tensor, masks: Tensor, alpha: float) -> Tensor:
    """Mean loss over a batch of logits and masks (0 or 1), both of shape (batch, rows, columns).

    The Dice coefficient is taken per map, on probabilities, so that maps with little contact weigh as much as others.
    """
    cross_entropy = functional.binary_cross_entropy_with_logits(logits, masks)
    probability = torch.sigmoid(logits)
    overlap = (probability * masks).sum(dim=(1, 2))
    total = probability.sum(dim=(1, 2)) + masks.sum(dim=(1, 2))
    dice = (2 * overlap / total).mean()
    return alpha * cross_entropy + (1 - alpha) * (1 - dice)
