"""From the network's probabilities to a contact mask, and how much the network doubts it."""

import numpy as np
from numpy.typing import NDArray

from solver.problem import BoolArray


def decide(probability: NDArray[np.float32]) -> BoolArray:
    """Contact where it is more likely than not; a load always touches somewhere, if need be at the likeliest pixel."""
    mask: BoolArray = probability > 0.5
    return mask if mask.any() else probability == probability.max()


def doubt(probability: NDArray[np.float32], mask: BoolArray) -> float:
    """1 - Dice that the mask would have on average if every pixel were in contact with its predicted probability."""
    overlap = float(probability[mask].sum(dtype=np.float64))
    return 1 - 2 * overlap / (float(probability.sum(dtype=np.float64)) + int(np.count_nonzero(mask)))
