"""What is done to heights before they are pressed, in this order: crop, fill, add the second surface, level, resample."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from PIL import Image
from scipy.ndimage import distance_transform_edt

from solver.problem import FloatArray

Detrend = Literal["none", "mean", "plane", "curvature"]


@dataclass(frozen=True)
class Crop:
    """A rectangle of a map."""

    first_row: int
    first_column: int
    rows: int
    columns: int


DEGREES: dict[Detrend, int] = {"mean": 0, "plane": 1, "curvature": 2}


def cropped(heights: FloatArray, crop: Crop) -> FloatArray:
    """The part of a map within a rectangle."""
    last_row, last_column = crop.first_row + crop.rows, crop.first_column + crop.columns
    return heights[crop.first_row : last_row, crop.first_column : last_column]


def filled(heights: FloatArray) -> FloatArray:
    """Every missing pixel with the height of the nearest measured one, the mean distance of pixels taken as equal."""
    missing = np.isnan(heights)
    if not missing.any():
        return heights
    nearest = distance_transform_edt(missing, return_distances=False, return_indices=True)
    result: FloatArray = heights[tuple(nearest)]
    return result


def composite(heights: FloatArray, second: FloatArray) -> FloatArray:
    """The one rough surface that touches a flat where two rough surfaces touch each other.

    Both maps are seen from outside their body, high touches first. Face to face the second is turned over about the
    vertical axis of the picture, so that its columns run backwards, and the heights add up.
    """
    result: FloatArray = heights + second[:, ::-1]
    return result


def detrended(heights: FloatArray, detrend: Detrend) -> FloatArray:
    """Without the polynomial of that degree that fits best in the sense of least squares."""
    if detrend == "none":
        return heights
    y, x = (np.linspace(-1, 1, side) for side in heights.shape)
    degree = DEGREES[detrend]
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    # The normal equations of a product grid: every sum over pixels is a product of sums over rows and columns.
    normal = [[(y ** (i + k)).sum() * (x ** (j + m)).sum() for k, m in powers] for i, j in powers]
    right = [(y**i) @ heights @ (x**j) for i, j in powers]
    fit = np.linalg.lstsq(np.array(normal), np.array(right), rcond=None)[0]
    trend = sum(c * np.outer(y**i, x**j) for c, (i, j) in zip(fit, powers, strict=True))
    result: FloatArray = heights - trend
    return result


def resampled(heights: FloatArray, shape: tuple[int, int]) -> FloatArray:
    """On a grid of another shape over the same area, by cubic convolution over as many pixels as a new one covers."""
    lowest, span = heights.min(), np.ptp(heights) or 1.0
    image = Image.fromarray(((heights - lowest) / span).astype(np.float32))
    scaled = np.asarray(image.resize(shape[::-1], Image.Resampling.BICUBIC), dtype=np.float64)
    result: FloatArray = lowest + span * scaled
    return result
