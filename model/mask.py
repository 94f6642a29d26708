"""Contact masks: from the network's probabilities, with how much it doubts them, and from a pressure and its gap."""

import numpy as np
from numpy.typing import NDArray

from solver.problem import BoolArray, ContactProblem, FloatArray


def decide(probability: NDArray[np.float32]) -> BoolArray:
    """Contact where it is more likely than not; a load always touches somewhere, if need be at the likeliest pixel."""
    mask: BoolArray = probability > 0.5
    return mask if mask.any() else probability == probability.max()


def doubt(probability: NDArray[np.float32], mask: BoolArray) -> float:
    """1 - Dice that the mask would have on average if every pixel were in contact with its predicted probability."""
    overlap = float(probability[mask].sum(dtype=np.float64))
    return 1 - 2 * overlap / (float(probability.sum(dtype=np.float64)) + int(np.count_nonzero(mask)))


def active(problem: ContactProblem, pressure: FloatArray, gap: FloatArray) -> BoolArray:
    """Where the bodies will touch, as a pressure that is not yet the solution and its gap tell it.

    Pressure above zero alone finds too much contact, because pixels leave it late. The primal-dual active set strategy
    (Hintermueller, Ito, Kunisch 2002, doi:10.1137/S1052623401383558) asks for more pressure than the gap takes away, at the
    stiffness E* / s of a pixel, s = sqrt(dx dy). At the exact solution the two are the same.
    """
    stiffness = problem.effective_modulus / np.sqrt(problem.pixel_area)
    mask: BoolArray = pressure > stiffness * gap
    return mask
