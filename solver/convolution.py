"""Displacement by pressure: discrete convolution with the influence coefficients, by the FFT (paper Eqs. 7, 10).

Dimensionless as in :mod:`solver.influence`. In single precision it costs half; the iteration uses that inside, and the
certificate the double one.
"""

from functools import lru_cache
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from solver.influence import free_coefficients, periodic_spectrum
from solver.problem import Boundary, FloatArray

Precision = Literal["float32", "float64"]

BLOCK = 32
"""Columns transformed at a time, few enough to stay in the cache."""


class Convolution(Protocol):
    """A linear map from pressure to displacement, both of shape (rows, columns)."""

    dtype: np.dtype[Any]

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Displacement in units of s, s = sqrt(dx dy), for a pressure in units of E* and of the convolution's dtype."""
        ...


def _padded(shape: tuple[int, int]) -> tuple[int, int]:
    """A size, good for the FFT, at which a free patch does not reach itself around the corner."""
    return fft.next_fast_len(2 * shape[0] - 1), fft.next_fast_len(2 * shape[1] - 1, real=True)


@lru_cache(maxsize=2)
def _free_spectrum(shape: tuple[int, int], pixel_size: tuple[float, float]) -> FloatArray:
    """Real FFT of the influence coefficients, shape (padded rows, padded columns // 2 + 1); real, for they are even."""
    rows, columns = shape
    coefficients = free_coefficients(shape, pixel_size)
    kernel = np.zeros(_padded(shape))
    kernel[:rows, :columns] = coefficients
    kernel[:rows, -columns + 1 :] = coefficients[:, :0:-1]
    kernel[-rows + 1 :, :] = kernel[rows - 1 : 0 : -1, :]
    return np.ascontiguousarray(fft.rfft2(kernel, overwrite_x=True).real)


class FreeConvolution:
    """Exact convolution on an isolated patch: zero padding to twice the size, transforms of zero rows left out."""

    def __init__(self, shape: tuple[int, int], pixel_size: tuple[float, float], precision: Precision) -> None:
        self.dtype = np.dtype(precision)
        self.shape = shape
        self.padded = _padded(shape)
        self.spectrum = _free_spectrum(shape, pixel_size).astype(precision, copy=False)

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        rows, columns = self.shape
        transform = fft.rfft(pressure, n=self.padded[1], axis=1)
        for first in range(0, transform.shape[1], BLOCK):
            block = slice(first, first + BLOCK)
            part = fft.fft(transform[:, block], n=self.padded[0], axis=0)
            part *= self.spectrum[:, block]
            transform[:, block] = fft.ifft(part, axis=0, overwrite_x=True)[:rows]
        displacement: NDArray[Any] = fft.irfft(transform, n=self.padded[1], axis=1)[:, :columns]
        return displacement


class PeriodicConvolution:
    """Exact convolution on a periodic surface; the mean displacement is zero."""

    def __init__(self, shape: tuple[int, int], pixel_size: tuple[float, float], precision: Precision) -> None:
        self.dtype = np.dtype(precision)
        self.shape = shape
        self.spectrum = periodic_spectrum(shape, pixel_size).astype(precision)

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        transform = fft.rfft2(pressure)
        transform *= self.spectrum
        displacement: NDArray[Any] = fft.irfft2(transform, s=self.shape, overwrite_x=True)
        return displacement


@lru_cache(maxsize=8)
def convolution(
    boundary: Boundary, shape: tuple[int, int], pixel_size: tuple[float, float], precision: Precision = "float64"
) -> Convolution:
    """The convolution for a boundary and grid; the few last used are kept."""
    kind = FreeConvolution if boundary == "free" else PeriodicConvolution
    return kind(shape, pixel_size, precision)
