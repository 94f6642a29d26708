"""The operators of the contact iteration, restricted to the pixels that may come into contact.

Arrays hold one value a candidate, shape (surfaces, count). Contact covers a few per cent of most maps, so everything but the
convolution becomes cheap.
"""

from functools import lru_cache

import numpy as np
from scipy import fft
from scipy.sparse import csr_array

from solver.arrays import Array, moved, namespace, sparse_product
from solver.convolution import Convolution
from solver.full_contact import Filter
from solver.influence import free_coefficients
from solver.problem import BoolArray, IntArray

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
    """Some pixels of a batch of surfaces, and displacement and preconditioner for pressures on them alone.

    Surfaces with fewer candidates than others are filled up with places that hold no pressure.

    Args:
        mask: which pixels, shape (surfaces, rows, columns), some of each surface.
        pixel_size: (dy, dx) in any unit.
        convolution: displacement by pressure on the whole grid.
        full_contact: the preconditioner if all pixels are candidates and nearly all touch; else it is the stencil.
    """

    def __init__(
        self,
        mask: BoolArray,
        pixel_size: tuple[float, float],
        convolution: Convolution,
        full_contact: Filter | None = None,
    ) -> None:
        self.shape = mask.shape
        self._dtype, self._device = convolution.dtype, convolution.device
        counts = np.count_nonzero(mask, axis=(1, 2))
        real = np.arange(counts.max()) < counts[:, np.newaxis]
        places = np.full(real.shape, mask.size)
        places[real] = np.flatnonzero(mask)
        self._real = moved(real, self._device)
        self._places = moved(places, self._device)
        self._inside = moved(np.minimum(places, mask.size - 1), self._device)
        self._displace = convolution.between(self._places)
        self._full_contact = full_contact
        if full_contact is None:
            self._stencil = sparse_product(_stencil_matrix(mask, places, stencil(pixel_size)), self._device)

    def gather(self, field: Array, fill: float) -> Array:
        """The values of a field, shape (surfaces, rows, columns), at the candidates; ``fill`` in places without one."""
        xp = namespace(field)
        return xp.where(self._real, xp.reshape(field, (-1,))[self._inside], fill)

    def scatter(self, values: Array) -> Array:
        """A field of shape (surfaces, rows, columns) with the values at the candidates, zero elsewhere."""
        field = moved(np.zeros(int(np.prod(self.shape)) + 1), self._device)
        field[self._places] = values
        return namespace(values).reshape(field[:-1], self.shape)

    def convolve(self, values: Array, scale: Array) -> Array:
        """Displacement at the candidates by pressures there, in the precision of the convolution.

        Args:
            values: pressures.
            scale: unit in which they are about one, shape (surfaces,), for single precision holds no extremes.
        """
        xp = namespace(values)
        scaled = xp.astype(values / scale[:, None], getattr(xp, self._dtype.name))
        return xp.astype(self._displace(scaled), xp.float64) * scale[:, None]

    def precondition(self, values: Array, working: Array) -> Array:
        """Roughly the pressures of some displacements that are zero off the working set, cut off there.

        Args:
            values: one a candidate.
            working: 1 on the working set, 0 off it.
        """
        xp = namespace(values)
        if self._full_contact is not None:
            return xp.reshape(self._full_contact(xp.reshape(values, self.shape)), values.shape) * working
        return xp.reshape(self._stencil(xp.reshape(values, (-1,))), values.shape) * working


def _stencil_matrix(mask: BoolArray, places: IntArray, coefficients: tuple[float, float, float, float]) -> csr_array:
    """The stencil between places as a sparse matrix; those of different surfaces have nothing to do with each other."""
    centre, above, beside, corner = coefficients
    weights = np.array([corner, above, corner, beside, centre, beside, corner, above, corner])
    surfaces, rows, columns = mask.shape
    real = np.flatnonzero(places < mask.size)
    numbers = np.full((surfaces, rows + 2, columns + 2), -1, dtype=np.int32)
    inner = np.zeros(numbers.shape, dtype=np.bool_)
    inner[:, 1:-1, 1:-1] = mask
    position = np.flatnonzero(inner)
    numbers.ravel()[position] = real
    offsets = [down * (columns + 2) + right for down in (-1, 0, 1) for right in (-1, 0, 1)]
    neighbours = np.take(numbers, position[:, np.newaxis] + np.array(offsets))
    found = neighbours >= 0
    ends = np.zeros(places.size + 1, dtype=np.int32)
    ends[real + 1] = np.count_nonzero(found, axis=1)
    parts = np.broadcast_to(weights, found.shape)[found], neighbours[found], np.cumsum(ends, dtype=np.int32)
    return csr_array(parts, shape=(places.size, places.size))
