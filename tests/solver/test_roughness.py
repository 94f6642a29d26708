import numpy as np
import pytest
from scipy.integrate import trapezoid

from solver.errors import InvalidHeightsError
from solver.midpoint import random_midpoint_displacement
from solver.roughness import power_spectrum, roughness
from solver.spectral import spectral_surface

Y, X = np.mgrid[:128, :96]
PIXEL = (2e-6, 1e-6)


def test_a_sinusoid_has_its_closed_forms() -> None:
    """Ra = 2 A / pi, Rq = A / sqrt(2), no skewness, kurtosis 3/2, rms slope A q / sqrt(2)."""
    q = 2 * np.pi / 48e-6
    measured = roughness(3e-6 * np.cos(q * (X - 47.5) * PIXEL[1]), PIXEL)
    assert measured.ra == pytest.approx(2 * 3e-6 / np.pi, rel=0.02)
    assert measured.rq == pytest.approx(3e-6 / np.sqrt(2), rel=0.02)
    assert measured.rsk == pytest.approx(0, abs=0.02)
    assert measured.rku == pytest.approx(1.5, rel=0.05)
    assert measured.rms_slope == pytest.approx(3e-6 * q / np.sqrt(2), rel=0.05)


def test_tilt_and_offset_do_not_count() -> None:
    heights = spectral_surface((128, 96), PIXEL, 1e-6, seed=1)
    tilted = roughness(heights + 0.1 * Y * PIXEL[0] - 0.3 * X * PIXEL[1] + 5e-6, PIXEL)
    plain = roughness(heights, PIXEL)
    assert vars(tilted) == pytest.approx(vars(plain), rel=1e-6)


def test_units_flips_and_transposition() -> None:
    heights = spectral_surface((128, 96), PIXEL, 1e-6, skewness=-1.0, seed=2)
    plain = roughness(heights, PIXEL)
    scaled = roughness(heights * 1e6, (2.0, 1.0))
    assert scaled.rq == pytest.approx(plain.rq * 1e6)
    assert scaled.rms_slope == pytest.approx(plain.rms_slope)
    assert scaled.psd_slope == pytest.approx(plain.psd_slope)
    flipped = roughness(-heights, PIXEL)
    assert flipped.rsk == pytest.approx(-plain.rsk)
    assert flipped.rku == pytest.approx(plain.rku)
    turned = roughness(heights.T, PIXEL[::-1])
    assert vars(turned) == pytest.approx(vars(plain), rel=1e-9)


@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.8])
def test_spectral_surfaces_have_the_spectrum_asked_for(hurst: float) -> None:
    slopes = [
        roughness(spectral_surface((256, 256), (1e-6, 1e-6), 1e-6, hurst, seed=seed), (1e-6, 1e-6)).psd_slope
        for seed in range(5)
    ]
    assert np.mean(slopes) == pytest.approx(-2 * (1 + hurst), abs=0.1)


@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.7])
def test_midpoint_surfaces_nearly_have_the_spectrum_asked_for(hurst: float) -> None:
    """Within 0.35: the interpolation between the displacements makes the spectrum a little steeper or flatter."""
    slopes = [roughness(random_midpoint_displacement(256, hurst, seed), (1.0, 1.0)).psd_slope for seed in range(5)]
    assert np.mean(slopes) == pytest.approx(-2 * (1 + hurst), abs=0.35)


@pytest.mark.parametrize("skewness", [-1.0, 0.0, 0.8])
def test_skewness_and_kurtosis_are_those_of_the_distribution(skewness: float) -> None:
    """Pearson III has a kurtosis of 3 + 3/2 skewness^2; long waves keep one surface from it by a little."""
    measured = roughness(
        spectral_surface((256, 256), (1.0, 1.0), 1.0, rolloff_wavelength=32.0, skewness=skewness, seed=3), (1.0, 1.0)
    )
    assert measured.rsk == pytest.approx(skewness, abs=0.05)
    assert measured.rku == pytest.approx(3 + 1.5 * skewness**2, abs=0.2)


def test_the_spectrum_integrates_to_the_variance() -> None:
    heights = spectral_surface((256, 256), (1e-6, 1e-6), 1e-6, rolloff_wavelength=30e-6, shortest_wavelength=6e-6, seed=4)
    q, density = power_spectrum(heights, (1e-6, 1e-6))
    assert trapezoid(2 * np.pi * q * density, q) == pytest.approx(1e-12, rel=0.1)


def test_roll_off_and_cut_off_show_in_the_spectrum() -> None:
    heights = spectral_surface((256, 256), (1e-6, 1e-6), 1e-6, rolloff_wavelength=32e-6, shortest_wavelength=8e-6, seed=5)
    q, density = power_spectrum(heights, (1e-6, 1e-6))
    plateau = density[(q > 2 * np.pi / 128e-6) & (q < 0.8 * 2 * np.pi / 32e-6)]
    assert plateau.max() < 3 * plateau.min()
    assert density[q > 1.2 * 2 * np.pi / 8e-6].max() < 1e-3 * plateau.min()


@pytest.mark.parametrize("heights", [np.zeros((64, 64)), X * 1e-6 + Y * 3e-6, np.ones((8, 64)), np.full((64, 64), np.nan)])
def test_what_cannot_be_measured_is_refused(heights: np.ndarray) -> None:
    with pytest.raises(InvalidHeightsError):
        roughness(heights, (1.0, 1.0))
