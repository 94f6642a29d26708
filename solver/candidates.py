"""The operators of the contact iteration, restricted to the pixels that may come into contact.

Vectors hold one value a candidate. Contact covers a few per cent of most maps, so everything but the convolution becomes
cheap.
"""

from functools import lru_cache

import numpy as np
from scipy import fft
from scipy.sparse import csr_array

from solver.convolution import Convolution
from solver.influence import free_coefficients
from solver.problem import BoolArray, FloatArray

REACH = 16
"""Pixels each way of the small periodic grid on which the operator is inverted."""


@lru_cache(maxsize=4)
def stencil(pixel_size: tuple[float, float]) -> tuple[float, float, float, float]:
    """The inverse of Love's operator, truncated to 3 x 3 pixels: centre, above and below, beside, corners.

    Displacement is smooth where pressure is rough, so its inverse is nearly local: 1.163, -0.183, -0.183, -0.048 for square
    pixels. The stencil is positive definite for any aspect, and as a preconditioner halves the iterations.

    Args:
        pixel_size: (dy, dx) in any unit; only the aspect matters.
    """
    quadrant = free_coefficients((REACH + 1, REACH + 1), pixel_size)
    distance = np.abs(np.arange(-REACH, REACH + 1))
    kernel = fft.ifftshift(quadrant[np.ix_(distance, distance)])
    inverse = fft.ifft2(1 / fft.fft2(kernel).real).real
    return float(inverse[0, 0]), float(inverse[1, 0]), float(inverse[0, 1]), float(inverse[1, 1])


class Candidates:
    """Some pixels of a grid, and displacement and preconditioner for pressures on them alone.

    Args:
        mask: which pixels, shape (rows, columns).
        pixel_size: (dy, dx) in any unit.
        convolve: displacement by pressure on the whole grid.
    """

    def __init__(self, mask: BoolArray, pixel_size: tuple[float, float], convolve: Convolution) -> None:
        self.indices = np.flatnonzero(mask)
        self._convolve = convolve
        self._grid = np.zeros(mask.shape, dtype=convolve.dtype)
        self._stencil = _stencil_matrix(mask, stencil(pixel_size))

    def gather(self, field: FloatArray) -> FloatArray:
        """The values of a field of shape (rows, columns) at the candidates."""
        values: FloatArray = field.ravel()[self.indices]
        return values

    def scatter(self, values: FloatArray) -> FloatArray:
        """A field of shape (rows, columns) with the values at the candidates, zero elsewhere."""
        field = np.zeros(self._grid.shape)
        field.ravel()[self.indices] = values
        return field

    def convolve(self, values: FloatArray) -> FloatArray:
        """Displacement at the candidates by pressures there, in the precision of the convolution."""
        scale = float(np.abs(values).max()) or 1.0
        self._grid.ravel()[self.indices] = values / scale
        displacement: FloatArray = self._convolve(self._grid).ravel()[self.indices].astype(np.float64)
        return displacement * scale

    def precondition(self, values: FloatArray, working: FloatArray) -> FloatArray:
        """The stencil applied to values that are zero off the working set, and cut off there.

        Args:
            values: one value a candidate, or several in columns.
            working: 1 on the working set, 0 off it.
        """
        result: FloatArray = self._stencil @ values
        result *= working if values.ndim == 1 else working[:, np.newaxis]
        return result


def _stencil_matrix(mask: BoolArray, coefficients: tuple[float, float, float, float]) -> csr_array:
    """The stencil between the pixels of a mask as a sparse matrix, (pixels, pixels)."""
    centre, above, beside, corner = coefficients
    rows, columns = mask.shape
    count = int(np.count_nonzero(mask))
    numbers = np.full((rows + 2, columns + 2), -1, dtype=np.int32)
    numbers[1:-1, 1:-1][mask] = np.arange(count, dtype=np.int32)
    pixels, neighbours, weights = [], [], []
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            neighbour = numbers[1 + down : rows + 1 + down, 1 + right : columns + 1 + right][mask]
            pixel = np.flatnonzero(neighbour >= 0).astype(np.int32)
            weight = corner if down and right else above if down else beside if right else centre
            pixels.append(pixel)
            neighbours.append(neighbour[pixel])
            weights.append(np.full(pixel.size, weight))
    return csr_array((np.concatenate(weights), (np.concatenate(pixels), np.concatenate(neighbours))), shape=(count, count))
