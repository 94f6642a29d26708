import numpy as np
import pytest
import torch

from model.features import CHANNELS, TYPICAL_LOG_LOAD, Features, features, network_input
from solver import ContactProblem, random_midpoint_displacement, solve

HEIGHTS = random_midpoint_displacement(64, seed=3) * 50e-6
PIXEL = 1e-3 / 64


def problem(**change: object) -> ContactProblem:
    given = {"heights": HEIGHTS, "pixel_size": (PIXEL, PIXEL), "load": 30.0, "effective_modulus": 6.843e9}
    return ContactProblem(**(given | change))  # type: ignore[arg-type]


def assert_close(ours: Features, others: Features) -> None:
    torch.testing.assert_close(network_input(ours), network_input(others), rtol=1e-3, atol=5e-3)
    torch.testing.assert_close(ours.conditions, others.conditions)


@pytest.mark.parametrize("shape", [(16, 16), (17, 50), (64, 33)])
def test_shape_follows_the_map(shape: tuple[int, int]) -> None:
    fields = network_input(features([problem(heights=HEIGHTS[: shape[0], : shape[1]])]))
    assert fields.shape == (1, CHANNELS, *shape)
    assert fields.dtype == torch.float32
    assert torch.isfinite(fields).all()


def test_features_have_no_units() -> None:
    """Lengths in another unit, a stiffer material, an offset: the same features."""
    reference = features([problem()])
    in_micrometres = problem(heights=HEIGHTS * 1e6 + 7, pixel_size=(PIXEL * 1e6, PIXEL * 1e6), effective_modulus=6.843e-3)
    stiffer = problem(load=300.0, effective_modulus=6.843e10)
    for other in (in_micrometres, stiffer):
        assert_close(features([other]), reference)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_features_turn_with_the_map(boundary: str) -> None:
    reference = features([problem(boundary=boundary, pixel_size=(PIXEL, 2 * PIXEL))])
    turned = features([problem(boundary=boundary, heights=HEIGHTS.T[::-1], pixel_size=(2 * PIXEL, PIXEL))])
    fields = network_input(turned).flip(2).transpose(2, 3)
    torch.testing.assert_close(fields, network_input(reference), rtol=1e-3, atol=5e-3)
    torch.testing.assert_close(turned.conditions * torch.tensor([1.0, -1.0]), reference.conditions)


def test_problems_together_have_the_features_of_each() -> None:
    several = [problem(load=load) for load in (1.0, 30.0, 200.0)]
    together = features(several)
    for i, one in enumerate(several):
        alone = features([one])
        torch.testing.assert_close(network_input(together)[i], network_input(alone)[0], rtol=1e-3, atol=2e-2)
        torch.testing.assert_close(together.load[i], alone.load[0])


def test_the_guessed_gap_tells_contact_from_separation() -> None:
    """Where the guess says deep overlap there is contact, where it says a wide gap there is none."""
    given = problem()
    gap = network_input(features([given]))[0, 0].numpy()
    mask = solve(given).contact_mask
    assert mask[gap < -1].mean() > 0.9
    assert mask[gap > 1].mean() < 0.01


def test_the_conditions_are_load_and_aspect() -> None:
    given = problem(pixel_size=(PIXEL, 3 * PIXEL))
    load = given.nominal_pressure / (given.effective_modulus * given.rms_slope)
    made = features([given])
    assert made.load.item() == pytest.approx(load, rel=1e-5)
    np.testing.assert_allclose(made.conditions[0], [np.log10(load) - TYPICAL_LOG_LOAD, -np.log(3)], rtol=1e-5)
