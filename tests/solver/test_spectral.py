import itertools

import numpy as np
import pytest
from scipy.stats import skew

from solver import InvalidProblemError, spectral_surface

SHAPE, PIXEL = (256, 256), (1e-6, 1e-6)


def radial_spectrum(heights: np.ndarray, pixel_size: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Mean power in rings of the wave number, in 1/m."""
    power = np.abs(np.fft.fft2(heights)) ** 2
    frequencies = [np.fft.fftfreq(side, pixel) for side, pixel in zip(heights.shape, pixel_size, strict=True)]
    q = 2 * np.pi * np.hypot(*np.meshgrid(*frequencies, indexing="ij"))
    edges = np.geomspace(2 * np.pi / 128e-6, 2 * np.pi / 2.1e-6, 20)
    rings = [(q >= low) & (q < high) for low, high in itertools.pairwise(edges)]
    return np.sqrt(edges[:-1] * edges[1:]), np.array([power[ring].mean() for ring in rings])


@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.9])
def test_the_spectrum_falls_with_the_hurst_exponent(hurst: float) -> None:
    q, power = radial_spectrum(spectral_surface(SHAPE, PIXEL, 1e-6, hurst, seed=1), PIXEL)
    slope = np.polyfit(np.log(q), np.log(power), 1)[0]
    assert slope == pytest.approx(-2 - 2 * hurst, abs=0.15)


def test_roll_off_and_short_cut_off() -> None:
    surface = spectral_surface(SHAPE, PIXEL, 1e-6, 0.8, rolloff_wavelength=32e-6, shortest_wavelength=8e-6, seed=2)
    q, power = radial_spectrum(surface, PIXEL)
    flat, cut = q < 0.9 * 2 * np.pi / 32e-6, q > 1.2 * 2 * np.pi / 8e-6
    assert np.abs(np.polyfit(np.log(q[flat]), np.log(power[flat]), 1)[0]) < 0.4
    assert power[cut].max() < 1e-12 * power.max()


@pytest.mark.parametrize("skewness", [0.0, -1.5, 0.8])
def test_heights_have_the_rms_and_skewness_asked_for(skewness: float) -> None:
    surfaces = [spectral_surface(SHAPE, PIXEL, 2e-6, 0.7, 32e-6, skewness=skewness, seed=seed) for seed in range(5)]
    for surface in surfaces:
        assert surface.std() == pytest.approx(2e-6, rel=1e-9)
        assert surface.mean() == pytest.approx(0, abs=1e-15)
    assert np.mean([skew(surface, axis=None) for surface in surfaces]) == pytest.approx(skewness, abs=0.1)


def test_skewed_heights_keep_their_spectrum() -> None:
    q, power = radial_spectrum(spectral_surface(SHAPE, PIXEL, 1e-6, 0.6, skewness=-1.0, seed=3), PIXEL)
    assert np.polyfit(np.log(q), np.log(power), 1)[0] == pytest.approx(-3.2, abs=0.3)


@pytest.mark.parametrize("anisotropy", [4.0, 1 / 4])
def test_anisotropy_stretches_the_correlation_along_columns(anisotropy: float) -> None:
    surface = spectral_surface(SHAPE, PIXEL, 1e-6, 0.8, 64e-6, anisotropy=anisotropy, seed=4)
    slopes = [np.std(np.diff(surface, axis=axis)) for axis in (0, 1)]
    assert slopes[1] / slopes[0] == pytest.approx(anisotropy, rel=0.35)


def test_the_surface_is_periodic_and_its_pixels_need_not_be_square() -> None:
    surface = spectral_surface((200, 120), (1e-6, 3e-6), 1e-6, 0.8, seed=5)
    seam, inside = np.std(surface[0] - surface[-1]), np.std(np.diff(surface, axis=0))
    assert seam < 2 * inside
    slopes = [np.std(np.diff(surface, axis=axis)) / pixel for axis, pixel in ((0, 1e-6), (1, 3e-6))]
    assert slopes[0] == pytest.approx(slopes[1], rel=0.5)
    np.testing.assert_array_equal(surface, spectral_surface((200, 120), (1e-6, 3e-6), 1e-6, 0.8, seed=5))


@pytest.mark.parametrize(
    "change",
    [{"hurst": -0.1}, {"hurst": 1.1}, {"rms_height": 0.0}, {"anisotropy": -1.0}, {"shortest_wavelength": 1.0}],
)
def test_bad_parameters_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(InvalidProblemError):
        spectral_surface(SHAPE, PIXEL, **({"rms_height": 1e-6} | change))
