"""Spectral synthesis: periodic rough surfaces of given power spectrum and height distribution."""

import numpy as np
from scipy import fft
from scipy.stats import pearson3

from solver.errors import InvalidProblemError
from solver.problem import FloatArray

MATCHING_ROUNDS = 50
"""Alternations between spectrum and heights of a skewed surface; they end with the heights."""


def spectral_surface(
    shape: tuple[int, int],
    pixel_size: tuple[float, float],
    rms_height: float,
    hurst: float = 0.8,
    rolloff_wavelength: float | None = None,
    shortest_wavelength: float | None = None,
    anisotropy: float = 1.0,
    skewness: float = 0.0,
    seed: int | None = None,
) -> FloatArray:
    """Rough surface with a self-affine power spectrum, C(q) ~ q^(-2 - 2 hurst).

    The spectrum is constant for wavelengths above the roll-off and zero for wavelengths below the shortest. Heights are
    Gaussian, or Pearson type III where a skewness is asked for; those are reached by alternating between the spectrum and
    the ranks of the heights, which leaves small deviations of the spectrum.

    Args:
        shape: (rows, columns).
        pixel_size: (dy, dx) in m.
        rms_height: root mean square of the heights about their mean, in m.
        hurst: Hurst exponent, from 0 to 1.
        rolloff_wavelength: in m; the longest wavelength of the map if left out.
        shortest_wavelength: in m; two pixels if left out.
        anisotropy: correlation length along columns (y) / along rows (x); its square root is shared by the two.
        skewness: of the heights; negative for plateaus with valleys.
        seed: of the random generator; the same seed gives the same surface.

    Returns:
        Heights in m with zero mean, shape (rows, columns), periodic.

    Raises:
        InvalidProblemError: a parameter out of its range, or no wavelength left between the two limits.

    Source: Jacobs, Junge & Pastewka 2017, doi:10.1088/2051-672X/aa51f8; for the alternation, Perez-Rafols & Almqvist 2019,
    Tribology International 131, 591.
    """
    if not 0 <= hurst <= 1:
        raise InvalidProblemError(f"The Hurst exponent is {hurst:g}; it must lie between 0 and 1.")
    for name, value in (("rms height", rms_height), ("anisotropy", anisotropy)):
        if not (np.isfinite(value) and value > 0):
            raise InvalidProblemError(f"The {name} is {value:g}; it must be positive and finite.")
    q = _wave_numbers(shape, pixel_size, anisotropy)
    lowest = 0.0 if rolloff_wavelength is None else 2 * np.pi / rolloff_wavelength
    highest = np.inf if shortest_wavelength is None else 2 * np.pi / shortest_wavelength
    inside = (q > 0) & (q <= highest)
    if not inside.any():
        raise InvalidProblemError(f"No wavelength of the map is longer than the shortest, {shortest_wavelength:g} m.")
    amplitude = np.zeros_like(q)
    amplitude[inside] = np.maximum(q[inside], lowest) ** (-1 - hurst)
    generator = np.random.default_rng(seed)
    noise = generator.standard_normal(shape)
    heights = _standardised(fft.irfft2(fft.rfft2(noise) * amplitude, s=shape))
    if skewness:
        heights = _skewed(heights, skewness)
    scaled: FloatArray = heights * rms_height
    return scaled


def _wave_numbers(shape: tuple[int, int], pixel_size: tuple[float, float], anisotropy: float) -> FloatArray:
    """|q| of the real FFT, with y stretched and x shrunk by the root of the anisotropy; shape (rows, columns // 2 + 1)."""
    stretch = np.sqrt(anisotropy)
    qy = 2 * np.pi * fft.fftfreq(shape[0], pixel_size[0])[:, np.newaxis] * stretch
    qx = 2 * np.pi * fft.rfftfreq(shape[1], pixel_size[1])[np.newaxis, :] / stretch
    q: FloatArray = np.hypot(qy, qx)
    return q


def _skewed(heights: FloatArray, skewness: float) -> FloatArray:
    """Heights of Pearson type III distribution whose spectrum is, nearly, that of the Gaussian ones."""
    probabilities = (np.arange(heights.size) + 0.5) / heights.size
    wanted = _standardised(pearson3.ppf(probabilities, skewness))
    spectrum = np.abs(fft.rfft2(heights))
    for _ in range(MATCHING_ROUNDS):
        ranked = np.empty(heights.size)
        ranked[np.argsort(heights, axis=None)] = wanted
        transform = fft.rfft2(ranked.reshape(heights.shape))
        phases = transform / np.maximum(np.abs(transform), np.finfo(np.float64).tiny)
        heights = fft.irfft2(phases * spectrum, s=heights.shape)
    return ranked.reshape(heights.shape)


def _standardised(heights: FloatArray) -> FloatArray:
    """Zero mean, unit standard deviation."""
    result: FloatArray = (heights - heights.mean()) / heights.std()
    return result
