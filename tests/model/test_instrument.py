import numpy as np

from model.instrument import as_measured, pixel_aspect
from solver import random_midpoint_displacement

SURFACE = random_midpoint_displacement(64, seed=1)


def made(seed: int) -> np.ndarray:
    return as_measured(SURFACE, np.random.default_rng(seed))


def test_heights_run_from_0_to_1_and_a_seed_gives_one_surface() -> None:
    for seed in range(30):
        heights = made(seed)
        assert (heights.min(), heights.max()) == (0, 1)
        np.testing.assert_array_equal(heights, made(seed))


def test_some_are_tilted_some_noisy_some_ground_in_one_direction() -> None:
    """A plane explains most of it; neighbouring steps differ at random; one direction is smoother."""
    tilted = noisy = ground = 0
    y, x = np.mgrid[:64, :64] / 64.0
    plane = np.stack([np.ones(64 * 64), y.ravel(), x.ravel()], axis=1)
    for seed in range(100):
        heights = made(seed)
        rest = heights.ravel() - plane @ np.linalg.lstsq(plane, heights.ravel(), rcond=None)[0]
        tilted += rest.var() < 0.1 * heights.var()
        roughness = rest.reshape(64, 64)
        steps = [np.diff(roughness, axis=axis) for axis in (0, 1)]
        noisy += bool(np.corrcoef(steps[1][:, 1:].ravel(), steps[1][:, :-1].ravel())[0, 1] < -0.3)
        rates = [np.diff(roughness, n=2, axis=axis).std() for axis in (0, 1)]
        ground += max(rates) > 2 * min(rates)
    assert 20 < tilted < 80
    assert 5 < noisy < 60
    assert 10 < ground < 70


def test_half_of_the_pixels_are_square() -> None:
    generator = np.random.default_rng(0)
    aspects = np.array([pixel_aspect(generator) for _ in range(400)])
    assert 0.4 < (aspects == 1).mean() < 0.6
    assert aspects.min() < 0.5
    assert aspects.max() > 2
