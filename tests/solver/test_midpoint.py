import numpy as np
import pytest

from solver import InvalidProblemError, random_midpoint_displacement


def test_a_seed_gives_one_surface_between_0_and_1() -> None:
    surface = random_midpoint_displacement(64, seed=1)
    assert surface.shape == (64, 64)
    assert (surface.min(), surface.max()) == (0, 1)
    np.testing.assert_array_equal(surface, random_midpoint_displacement(64, seed=1))
    assert (surface != random_midpoint_displacement(64, seed=2)).any()


@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.8])
def test_increments_grow_with_distance_to_the_power_of_the_hurst_exponent(hurst: float) -> None:
    """Within 0.1: midpoint displacement interpolates linearly, which roughens smooth surfaces a little."""
    structure = np.zeros(5)
    lags = 2 ** np.arange(5)
    for seed in range(40):
        surface = random_midpoint_displacement(128, hurst, seed)
        structure += [np.mean((surface[:, lag:] - surface[:, :-lag]) ** 2) for lag in lags]
    slope = np.polyfit(np.log(lags), np.log(structure), 1)[0] / 2
    assert slope == pytest.approx(hurst, abs=0.1)


def test_roughness_is_the_papers() -> None:
    """Ra of about 7 um for heights from 0 to 50 um (paper section 2.1)."""
    surfaces = [random_midpoint_displacement(128, seed=seed) * 50 for seed in range(60)]
    ra = np.mean([np.abs(surface - surface.mean()).mean() for surface in surfaces])
    assert ra == pytest.approx(7, abs=0.7)


@pytest.mark.parametrize(("size", "hurst"), [(100, 0.5), (2, 0.5), (64, 1.0), (64, -0.1)])
def test_bad_arguments_are_refused(size: int, hurst: float) -> None:
    with pytest.raises(InvalidProblemError):
        random_midpoint_displacement(size, hurst)
