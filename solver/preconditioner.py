"""Preconditioner of the contact iteration: the inverse of Love's operator, truncated to 3 x 3 pixels.

Displacement is smooth where pressure is rough, so its inverse is nearly local; on a contact set, cut off at its edges, it
takes half of the iterations away.
"""

from functools import lru_cache

import numpy as np
from scipy import fft

from solver.influence import free_coefficients
from solver.problem import BoolArray, FloatArray

REACH = 16
"""Pixels each way of the small periodic grid on which the operator is inverted."""


class Preconditioner:
    """A symmetric, positive definite 3 x 3 stencil (1.163 at the centre, -0.183 and -0.048 around it for square pixels).

    Args:
        pixel_size: (dy, dx) in any unit; only the aspect matters.
    """

    def __init__(self, pixel_size: tuple[float, float]) -> None:
        quadrant = free_coefficients((REACH + 1, REACH + 1), pixel_size)
        distance = np.abs(np.arange(-REACH, REACH + 1))
        kernel = fft.ifftshift(quadrant[np.ix_(distance, distance)])
        inverse = fft.ifft2(1 / fft.fft2(kernel).real).real
        self.centre, self.above = float(inverse[0, 0]), float(inverse[1, 0])
        self.beside, self.corner = float(inverse[0, 1]), float(inverse[1, 1])

    def __call__(self, field: FloatArray, working: BoolArray) -> FloatArray:
        """The stencil applied to a field that is zero off the working set, and cut off there; shape (rows, columns)."""
        vertical = np.zeros_like(field)
        vertical[1:] = field[:-1]
        vertical[:-1] += field[1:]
        result = self.centre * field + self.above * vertical
        sideways = self.beside * field + self.corner * vertical
        result[:, 1:] += sideways[:, :-1]
        result[:, :-1] += sideways[:, 1:]
        result[~working] = 0.0
        return result


@lru_cache(maxsize=4)
def preconditioner(pixel_size: tuple[float, float]) -> Preconditioner:
    """The preconditioner for pixels; the few last used are kept."""
    return Preconditioner(pixel_size)
