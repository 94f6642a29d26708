"""Statistics of a height map, as roughness standards and contact theories use them."""

from dataclasses import dataclass

import numpy as np
from scipy import fft
from scipy.signal.windows import hann

from solver.errors import InvalidHeightsError
from solver.problem import FloatArray

SMALLEST_SIDE = 16
"""Pixels a side from which there are enough wave numbers for a slope."""

LOWEST_WAVE, HIGHEST_WAVE = 4.0, 0.5
"""The slope is fitted from this many waves along the shorter side to this share of the Nyquist wave number."""

BINS_A_DECADE = 12


@dataclass(frozen=True)
class Roughness:
    """Heights about their mean plane (ISO 25178-2, ISO 4287 with areas for lengths).

    Attributes:
        ra: mean deviation, in m.
        rq: root mean square deviation, in m.
        rsk: skewness; negative for plateaus with valleys.
        rku: kurtosis; 3 for Gaussian heights.
        rms_slope: root mean square of the gradient by forward differences.
        psd_slope: exponent of the power spectrum, C(q) ~ q^slope; -2 (1 + Hurst exponent) for self-affine surfaces.
    """

    ra: float
    rq: float
    rsk: float
    rku: float
    rms_slope: float
    psd_slope: float


def roughness(heights: FloatArray, pixel_size: tuple[float, float]) -> Roughness:
    """Measure a height map.

    Args:
        heights: in m, shape (rows, columns), finite, at least 16 each way.
        pixel_size: (dy, dx) in m.

    Raises:
        InvalidHeightsError: a map that is too small, or flat.
    """
    _check(heights)
    level = _levelled(heights)
    rq = float(level.std())
    if rq <= 1e-14 * float(np.abs(heights).max()):
        raise InvalidHeightsError("The heights form a plane; there is no roughness to measure.")
    dy, dx = pixel_size
    slopes = np.diff(level, axis=0) / dy, np.diff(level, axis=1) / dx
    return Roughness(
        ra=float(np.abs(level).mean()),
        rq=rq,
        rsk=float(np.mean((level / rq) ** 3)),
        rku=float(np.mean((level / rq) ** 4)),
        rms_slope=float(np.sqrt(sum(np.mean(slope**2) for slope in slopes))),
        psd_slope=_fitted_slope(heights, pixel_size),
    )


def power_spectrum(heights: FloatArray, pixel_size: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Isotropic power spectral density: the periodogram averaged over rings of wave numbers.

    The mean plane is taken out and a Hann window applied, for measured maps do not continue beyond their edges.

    Args:
        heights: in m, shape (rows, columns), finite, at least 16 each way.
        pixel_size: (dy, dx) in m.

    Returns:
        Mean wave number of each ring that holds any, in rad/m, ascending, up to the lower of the two Nyquist wave numbers;
        and C in m^4, whose integral over the plane of wave numbers is the variance of the heights.

    Raises:
        InvalidHeightsError: a map that is too small.

    Source: Jacobs, Junge & Pastewka 2017, doi:10.1088/2051-672X/aa51f8.
    """
    _check(heights)
    rows, columns = heights.shape
    dy, dx = pixel_size
    window = np.outer(hann(rows, sym=False), hann(columns, sym=False))
    transform = fft.fft2(_levelled(heights) * window / np.sqrt(np.mean(window**2)))
    density = np.abs(transform) ** 2 * (dy * dx / (rows * columns * (2 * np.pi) ** 2))
    q = 2 * np.pi * np.hypot(fft.fftfreq(rows, dy)[:, np.newaxis], fft.fftfreq(columns, dx))
    lowest, highest = 2 * np.pi / max(rows * dy, columns * dx), np.pi / max(dy, dx)
    edges = np.geomspace(lowest / 1.01, highest, int(np.log10(highest / lowest) * BINS_A_DECADE) + 2)
    inside = (q >= edges[0]) & (q <= edges[-1])
    ring = np.digitize(q[inside], edges)
    count = np.bincount(ring)
    held = count > 0
    mean_q, mean_density = (np.bincount(ring, values)[held] / count[held] for values in (q[inside], density[inside]))
    return mean_q, mean_density


def _check(heights: FloatArray) -> None:
    if heights.ndim != 2 or min(heights.shape) < SMALLEST_SIDE or not np.isfinite(heights).all():
        raise InvalidHeightsError(
            f"The height map has shape {heights.shape}; roughness needs finite heights, at least {SMALLEST_SIDE} pixels "
            "each way."
        )


def _levelled(heights: FloatArray) -> FloatArray:
    """Heights less their mean plane."""
    rows, columns = heights.shape
    y = (np.arange(rows) - (rows - 1) / 2)[:, np.newaxis]
    x = (np.arange(columns) - (columns - 1) / 2)[np.newaxis, :]
    level = heights - heights.mean()
    tilt_y, tilt_x = (level * y).sum() / (columns * (y**2).sum()), (level * x).sum() / (rows * (x**2).sum())
    result: FloatArray = level - tilt_y * y - tilt_x * x
    return result


def _fitted_slope(heights: FloatArray, pixel_size: tuple[float, float]) -> float:
    """Slope of the logarithm of the spectrum, every ring weighted the same."""
    q, density = power_spectrum(heights, pixel_size)
    shorter = min(side * step for side, step in zip(heights.shape, pixel_size, strict=True))
    lowest = min(LOWEST_WAVE * 2 * np.pi / shorter, q[-1] * HIGHEST_WAVE / 2)
    fitted = (q >= lowest) & (q <= HIGHEST_WAVE * q[-1]) & (density > 0)
    slope, _ = np.polyfit(np.log(q[fitted]), np.log(density[fitted]), 1)
    return float(slope)
