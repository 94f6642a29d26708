import numpy as np
import pytest
import torch

from model.features import CHANNELS, LOAD_CHANNEL, features
from solver import ContactProblem, random_midpoint_displacement, solve

HEIGHTS = random_midpoint_displacement(64, seed=3) * 50e-6
PIXEL = 1e-3 / 64


def problem(**change: object) -> ContactProblem:
    given = {"heights": HEIGHTS, "pixel_size": (PIXEL, PIXEL), "load": 30.0, "effective_modulus": 6.843e9}
    return ContactProblem(**(given | change))  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", [(16, 16), (17, 50), (64, 33)])
def test_shape_follows_the_map(shape: tuple[int, int]) -> None:
    inputs = features(problem(heights=HEIGHTS[: shape[0], : shape[1]]))
    assert inputs.shape == (CHANNELS, *shape)
    assert inputs.dtype == torch.float32
    assert torch.isfinite(inputs).all()


def test_features_have_no_units() -> None:
    """Lengths in another unit, a stiffer material, an offset: the same features."""
    reference = features(problem())
    in_micrometres = problem(heights=HEIGHTS * 1e6 + 7, pixel_size=(PIXEL * 1e6, PIXEL * 1e6), effective_modulus=6.843e-3)
    stiffer = problem(load=300.0, effective_modulus=6.843e10)
    for other in (in_micrometres, stiffer):
        torch.testing.assert_close(features(other), reference, rtol=1e-3, atol=2e-3)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_features_turn_with_the_map(boundary: str) -> None:
    reference = features(problem(boundary=boundary, pixel_size=(PIXEL, 2 * PIXEL)))
    turned = features(problem(boundary=boundary, heights=HEIGHTS.T[::-1], pixel_size=(2 * PIXEL, PIXEL)))
    torch.testing.assert_close(turned.flip(1).transpose(1, 2), reference, rtol=1e-3, atol=2e-3)


def test_the_guessed_gap_tells_contact_from_separation() -> None:
    """Where the guess says deep overlap there is contact, where it says a wide gap there is none."""
    given = problem()
    gap = features(given)[0].numpy()
    mask = solve(given).contact_mask
    assert mask[gap < -1].mean() > 0.9
    assert mask[gap > 1].mean() < 0.01


def test_the_load_channel_is_the_dimensionless_load() -> None:
    given = problem()
    expected = np.log10(given.nominal_pressure / (given.effective_modulus * given.rms_slope))
    assert features(given)[LOAD_CHANNEL].unique().item() == pytest.approx(expected, rel=1e-6)
