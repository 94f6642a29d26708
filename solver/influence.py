"""Influence coefficients of the half-space: the displacement by unit pressure on one rectangular pixel.

Dimensionless: lengths in units of s = sqrt(dx dy), pressures in units of E*, so that the coefficients depend on the shape
of the grid and the aspect of its pixels alone.
"""

import numpy as np

from solver.problem import FloatArray


def free_coefficients(
    shape: tuple[int, int], pixel_size: tuple[float, float], stride: tuple[int, int] = (1, 1)
) -> FloatArray:
    """Love's influence coefficients of an isolated half-space for all non-negative pixel distances (paper Eqs. 5, 7).

    The logarithms of Love's formula are written with log1p of differences formed without cancellation, so that the far
    coefficients keep about 12 digits on a 4096 x 4096 grid.

    Args:
        shape: (rows, columns) of the grid.
        pixel_size: (dy, dx) in any unit; only the aspect matters.
        stride: (rows, columns) from one distance to the next.

    Returns:
        K of shape (rows, columns): K[i, j] is the displacement i strides of rows and j of columns away from a pixel under
        unit pressure, in units of s / E*.

    Source: Love 1929, doi:10.1098/rsta.1929.0009; Johnson, Contact Mechanics, Eq. 3.25.
    """
    dy, dx = pixel_size
    height, width = np.sqrt(dy / dx), np.sqrt(dx / dy)
    y = (np.arange(shape[0]) * stride[0] * height)[:, np.newaxis]
    x = (np.arange(shape[1]) * stride[1] * width)[np.newaxis, :]
    a, b = width / 2, height / 2
    coefficients: FloatArray = (_edge(x + a, y, b) - _edge(x - a, y, b) + _edge(y + b, x, a) - _edge(y - b, x, a)) / np.pi
    return coefficients


def _edge(offset: FloatArray, along: FloatArray, half_length: float) -> FloatArray:
    """offset * ln((along + half + R+) / (along - half + R-)), R+- the distances to the ends of one pixel edge."""
    near = np.hypot(offset, along - half_length)
    far = np.hypot(offset, along + half_length)
    excess = 2 * half_length + 4 * along * half_length / (near + far)
    logarithm: FloatArray = offset * np.log1p(excess / (along - half_length + near))
    return logarithm


def periodic_spectrum(shape: tuple[int, int], pixel_size: tuple[float, float]) -> FloatArray:
    """Real-FFT spectrum of the periodic half-space, 2 / (E* |q|), with the mean displacement set to zero.

    Args:
        shape: (rows, columns) of the grid.
        pixel_size: (dy, dx) in any unit; only the aspect matters.

    Returns:
        Spectrum of shape (rows, columns // 2 + 1), in units of s / E*.

    Source: Stanley & Kato 1997, doi:10.1115/1.2833523.
    """
    dy, dx = pixel_size
    scale = np.sqrt(dy * dx)
    qy = 2 * np.pi * np.fft.fftfreq(shape[0], dy / scale)[:, np.newaxis]
    qx = 2 * np.pi * np.fft.rfftfreq(shape[1], dx / scale)[np.newaxis, :]
    q = np.hypot(qy, qx)
    q[0, 0] = np.inf
    spectrum: FloatArray = 2 / q
    return spectrum
