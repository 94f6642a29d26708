"""Displacement by pressure: discrete convolution with the influence coefficients, by the FFT (paper Eqs. 7, 10).

Dimensionless as in :mod:`solver.influence`. In single precision it costs half; the iteration uses that inside, and the
certificate the double one.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import lru_cache
from typing import Any, Literal, Protocol

import numpy as np
from scipy import fft

from solver.arrays import Array, Device, fourier, moved, namespace
from solver.influence import free_coefficients, periodic_spectrum
from solver.problem import Boundary, FloatArray
from solver.threads import side_by_side, threads

Precision = Literal["float32", "float64"]

CACHED = 2**19
"""Bytes transformed at a time on a processor, few enough to stay in the cache."""


class Convolution(Protocol):
    """A linear map from pressure to displacement, for one surface or a batch of them."""

    dtype: np.dtype[Any]
    device: Device

    def __call__(self, pressure: Array) -> Array:
        """Displacement in units of s, s = sqrt(dx dy), for a pressure in units of E* and of the convolution's dtype.

        Both have the shape (..., rows, columns).
        """
        ...

    def between(self, places: Array) -> Callable[[Array], Array]:
        """The map restricted to some pixels.

        Args:
            places: their indices in the flattened batch, shape (surfaces, count). Surfaces with fewer pixels are filled up
                with one index past the end, where pressures are dropped and displacements mean nothing.

        Returns:
            A function from pressures to displacements there, of the convolution's dtype, shape (surfaces, count).
        """
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


class _FourierConvolution(ABC):
    """What the convolutions of both boundaries share.

    Args:
        shape: (rows, columns).
        width: columns of the array that the inverse transform makes, of which the first are the displacement.
        spectrum: what the transform of the pressure is multiplied by.
        precision: of the transforms.
        device: where they run; on a processor those along columns run in parts that stay in its cache.
    """

    def __init__(
        self, shape: tuple[int, int], width: int, spectrum: FloatArray, precision: Precision, device: Device
    ) -> None:
        self.dtype = np.dtype(precision)
        self.device = device
        self.shape = shape
        self.width = width
        self.spectrum = moved(spectrum.astype(precision, copy=False), device)
        self.parts = -(-spectrum.size * self.dtype.itemsize * 2 // CACHED) if device is None else 1
        self.workers = threads() if self.parts > 1 else 1

    @abstractmethod
    def _wide(self, pressure: Array) -> Array:
        """Displacement and what the padding leaves behind it, shape (surfaces, rows, width)."""

    def __call__(self, pressure: Array) -> Array:
        batch = namespace(pressure).reshape(pressure, (-1, *self.shape))
        return namespace(pressure).reshape(self._wide(batch)[..., : self.shape[1]], pressure.shape)

    def between(self, places: Array) -> Callable[[Array], Array]:
        rows, columns = self.shape
        xp = namespace(places)
        surfaces = places.shape[0]
        size = surfaces * rows * columns
        grid = moved(np.zeros(size + 1, self.dtype), self.device)
        inside = xp.clip(places, 0, size - 1)
        wide = inside + inside // columns * (self.width - columns)

        def apply(values: Array) -> Array:
            grid[places] = values
            displacement = self._wide(xp.reshape(grid[:size], (surfaces, rows, columns)))
            return xp.reshape(displacement, (-1,))[wide]

        return apply


class FreeConvolution(_FourierConvolution):
    """Exact convolution on an isolated patch: zero padding to twice the size, transforms of zero rows left out."""

    def __init__(
        self, shape: tuple[int, int], pixel_size: tuple[float, float], precision: Precision, device: Device
    ) -> None:
        self.padded = _padded(shape)
        super().__init__(shape, self.padded[1], _free_spectrum(shape, pixel_size), precision, device)

    def _wide(self, pressure: Array) -> Array:
        if isinstance(pressure, np.ndarray):
            displacement = np.empty((*pressure.shape[:-1], self.width), self.dtype)
            for one, result in zip(pressure, displacement, strict=True):
                result[:] = self._displacement(one)
            return displacement
        return self._displacement(pressure)

    def _displacement(self, pressure: Array) -> Array:
        rows = self.shape[0]
        transforms = fourier(pressure)
        with fft.set_workers(self.workers):
            transform = transforms.rfft(pressure, n=self.padded[1], axis=-1)

        def transform_columns(columns: slice) -> None:
            part = transforms.fft(transform[..., columns], n=self.padded[0], axis=-2)
            part *= self.spectrum[:, columns]
            transform[..., columns] = transforms.ifft(part, axis=-2)[..., :rows, :]

        block = -(-transform.shape[-1] // self.parts)
        side_by_side(transform_columns, [slice(first, first + block) for first in range(0, transform.shape[-1], block)])
        with fft.set_workers(self.workers):
            return transforms.irfft(transform, n=self.padded[1], axis=-1)


class PeriodicConvolution(_FourierConvolution):
    """Exact convolution on a periodic surface; the mean displacement is zero."""

    def __init__(
        self, shape: tuple[int, int], pixel_size: tuple[float, float], precision: Precision, device: Device
    ) -> None:
        super().__init__(shape, shape[1], periodic_spectrum(shape, pixel_size), precision, device)

    def _wide(self, pressure: Array) -> Array:
        transforms = fourier(pressure)
        with fft.set_workers(self.workers):
            transform = transforms.rfftn(pressure, axes=(-2, -1))
            transform *= self.spectrum
            return transforms.irfftn(transform, s=self.shape, axes=(-2, -1))


@lru_cache(maxsize=8)
def convolution(
    boundary: Boundary,
    shape: tuple[int, int],
    pixel_size: tuple[float, float],
    precision: Precision = "float64",
    device: Device = None,
) -> Convolution:
    """The convolution for a boundary and grid; the few last used are kept."""
    kind = FreeConvolution if boundary == "free" else PeriodicConvolution
    return kind(shape, pixel_size, precision, device)
