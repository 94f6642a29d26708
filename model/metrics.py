"""How well a predicted contact mask matches a reference (paper Eqs. 14, 17-21)."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, binary_erosion

from solver.problem import BoolArray

BOUNDARY_TOLERANCE = 2
"""Distance, in pixels, within which a boundary pixel counts as matched in the BF score."""


@dataclass(frozen=True)
class Comparison:
    """Agreement of a predicted mask with a reference mask.

    Attributes:
        dice: 2 TP / (2 TP + FP + FN), Eq. 14.
        jaccard: TP / (TP + FP + FN), Eq. 18.
        bf_score: boundary F1 score at a tolerance of ``BOUNDARY_TOLERANCE`` pixels. (The paper's Eqs. 19-21, taken over
            all pixels as printed, equal Dice; its tables can only be the boundary score.)
        pixel_accuracy: (TP + TN) / all, Eq. 17.
        area_error: predicted / reference contact area - 1.
    """

    dice: float
    jaccard: float
    bf_score: float
    pixel_accuracy: float
    area_error: float


def dice(one: BoolArray, other: BoolArray) -> float:
    """Dice coefficient of two masks of the same shape, of which one at least has contact somewhere (Eq. 14)."""
    return 2 * int(np.count_nonzero(one & other)) / (int(np.count_nonzero(one)) + int(np.count_nonzero(other)))


def compare(reference: BoolArray, predicted: BoolArray) -> Comparison:
    """Compare two masks of the same shape; the reference must have contact somewhere."""
    true_positive = int(np.count_nonzero(reference & predicted))
    in_reference = int(np.count_nonzero(reference))
    in_predicted = int(np.count_nonzero(predicted))
    union = in_reference + in_predicted - true_positive
    return Comparison(
        dice=dice(reference, predicted),
        jaccard=true_positive / union,
        bf_score=bf_score(reference, predicted),
        pixel_accuracy=1 - (union - true_positive) / reference.size,
        area_error=in_predicted / in_reference - 1,
    )


def bf_score(reference: BoolArray, predicted: BoolArray, tolerance: int = BOUNDARY_TOLERANCE) -> float:
    """Boundary F1: harmonic mean of the shares of either mask's boundary pixels within the tolerance of the other's.

    Boundary pixels are those of the contact that have a neighbour (of four) out of contact; the tolerance is a Euclidean
    distance in pixels.

    Source: Csurka et al. 2013, What is a good evaluation measure for semantic segmentation?, doi:10.5244/C.27.32.
    """
    reference_boundary, predicted_boundary = _boundary(reference), _boundary(predicted)
    if not predicted_boundary.any():
        return 0.0
    offsets = np.arange(-tolerance, tolerance + 1)
    disc = np.hypot(*np.meshgrid(offsets, offsets)) <= tolerance
    precision = (predicted_boundary & binary_dilation(reference_boundary, disc)).sum() / predicted_boundary.sum()
    recall = (reference_boundary & binary_dilation(predicted_boundary, disc)).sum() / reference_boundary.sum()
    return float(2 * precision * recall / (precision + recall)) if precision + recall > 0 else 0.0


def _boundary(mask: BoolArray) -> BoolArray:
    """Pixels of the mask with a neighbour outside; the edge of the map is no boundary unless the mask fills the map."""
    boundary: BoolArray = mask & ~binary_erosion(mask, border_value=1)
    return boundary if boundary.any() else mask
