from collections.abc import Callable

import numpy as np
import pytest

from solver import ContactProblem, InvalidProblemError, boyer_resistance, constriction_resistance, solve
from solver.closed_forms import SQUARE_PUNCH_STIFFNESS, annulus_resistance
from solver.errors import InvalidMaterialError, NotConvergedError
from solver.midpoint import random_midpoint_displacement
from solver.resistance import constriction_current


def written_as_it_reads(mask: np.ndarray, pixel_size: tuple[float, float], resistivity: float) -> float:
    """The paper's Eq. 26, pair by pair."""
    at = np.argwhere(mask) * np.array(pixel_size)
    distances = np.hypot(*(at[:, np.newaxis, :] - at[np.newaxis, :, :]).transpose(2, 0, 1))
    count = len(at)
    pairs = (1 / distances[~np.eye(count, dtype=bool)]).sum()
    side = np.sqrt(pixel_size[0] * pixel_size[1])
    return resistivity * (0.868 / (count * side) + pairs / (np.pi * count**2))


@pytest.mark.parametrize("shape", [(16, 16), (7, 30)])
@pytest.mark.parametrize("pixel_size", [(1e-6, 1e-6), (1e-6, 3e-6)])
def test_the_autocorrelation_gives_the_double_sum(shape: tuple[int, int], pixel_size: tuple[float, float]) -> None:
    mask = np.random.default_rng(0).random(shape) < 0.3
    expected = written_as_it_reads(mask, pixel_size, 1.7e-8)
    assert boyer_resistance(mask, pixel_size, 1.7e-8) == pytest.approx(expected, rel=1e-12)


def test_one_pixel_is_one_square_spot() -> None:
    mask = np.zeros((9, 9), dtype=bool)
    mask[4, 4] = True
    assert boyer_resistance(mask, (2e-6, 2e-6), 1.7e-8) == pytest.approx(0.868 * 1.7e-8 / 2e-6)


def test_a_disc_is_within_eight_percent_above_the_isothermal_disc() -> None:
    """R = rho / (2 a); equal current in every pixel overestimates, as measured, by 7 %."""
    y, x = np.mgrid[-64:64, -64:64] + 0.5
    mask = np.hypot(y, x) < 40
    radius = np.sqrt(mask.sum() / np.pi)
    assert 1.0 < boyer_resistance(mask, (1.0, 1.0), 1.0) * 2 * radius < 1.08


@pytest.mark.parametrize("resistance", [boyer_resistance, constriction_resistance])
def test_no_contact_and_bad_resistivity_are_refused(resistance: Callable[..., float]) -> None:
    mask = np.zeros((8, 8), dtype=bool)
    with pytest.raises(InvalidProblemError, match="infinite"):
        resistance(mask, (1.0, 1.0), 1.0)
    mask[0, 0] = True
    for resistivity in (0.0, -1.0, np.nan):
        with pytest.raises(InvalidMaterialError):
            resistance(mask, (1.0, 1.0), resistivity)


DISTANCE = np.hypot(*np.mgrid[-100:100, -100:100] + 0.5)


def test_an_isothermal_disc() -> None:
    """R = rho / (2 a) (Holm)."""
    mask = DISTANCE < 80
    radius = np.sqrt(mask.sum() / np.pi)
    assert constriction_resistance(mask, (1e-6, 1e-6), 1.7e-8) == pytest.approx(1.7e-8 / (2e-6 * radius), rel=3e-3)


def test_an_isothermal_square() -> None:
    """R = 0.868 rho / L, approached from above as the pixels get smaller."""
    errors = []
    for side in (20, 40, 80):
        mask = np.zeros((100, 90), dtype=bool)
        mask[5 : 5 + side, 3 : 3 + side] = True
        errors.append(constriction_resistance(mask, (1.0, 1.0), 1.0) * side * SQUARE_PUNCH_STIFFNESS - 1)
    assert errors[0] > errors[1] > errors[2] > 0
    assert errors[2] < 5e-3


def test_two_distant_discs() -> None:
    """Half of one disc's resistance and rho / (2 pi d) for their distance d (Greenwood 1966, two equal spots)."""
    y, x = np.mgrid[:30, :400]
    one, other = np.hypot(y - 15, x - 20) < 8, np.hypot(y - 15, x - 380) < 8
    alone = constriction_resistance(one, (1.0, 1.0), 1.0)
    assert constriction_resistance(one | other, (1.0, 1.0), 1.0) == pytest.approx(
        alone / 2 + 1 / (2 * np.pi * 360), rel=1e-4
    )


@pytest.mark.parametrize("ratio", [0.5, 0.8])
def test_an_annulus(ratio: float) -> None:
    mask = (DISTANCE < 90) & (90 * ratio < DISTANCE)
    assert constriction_resistance(mask, (1.0, 1.0), 1.0) == pytest.approx(
        annulus_resistance(90 * ratio, 90.0, 1.0), rel=5e-3
    )


def test_pixels_that_are_not_square() -> None:
    """The same square of 40 x 40 um in pixels of 1 x 1 and of 2 x 0.5 um."""
    square, oblong = np.ones((40, 40), dtype=bool), np.ones((20, 80), dtype=bool)
    resistances = [constriction_resistance(square, (1e-6, 1e-6), 1.0), constriction_resistance(oblong, (2e-6, 0.5e-6), 1.0)]
    assert resistances[0] == pytest.approx(resistances[1], rel=0.01)


def test_conductance_is_incremental_stiffness() -> None:
    """Barber's analogy 1/R = dF/d(approach) / (rho E*), from two nearby loads, on a rough surface."""
    heights = random_midpoint_displacement(64, seed=5) * 50e-6
    given = {"heights": heights, "pixel_size": (1e-3 / 64, 1e-3 / 64), "effective_modulus": 6.843e9}
    light, heavy = (solve(ContactProblem(load=load, **given), tolerance=1e-9) for load in (29.9, 30.1))  # type: ignore[arg-type]
    stiffness = 0.2 / (heavy.approach - light.approach)
    middle = solve(ContactProblem(load=30.0, **given), tolerance=1e-9).contact_mask  # type: ignore[arg-type]
    resistance = constriction_resistance(middle, (1e-3 / 64, 1e-3 / 64), 1.0)
    assert resistance == pytest.approx(6.843e9 / stiffness, rel=0.02)
    assert boyer_resistance(middle, (1e-3 / 64, 1e-3 / 64), 1.0) > 1.02 * resistance


def test_a_start_near_the_solution_and_a_tolerance_out_of_reach() -> None:
    mask = DISTANCE[:50] < 90
    current = constriction_current(mask, (1.0, 1.0), tolerance=1e-10)
    again = constriction_current(mask, (1.0, 1.0), tolerance=1e-8, initial_current=current)
    np.testing.assert_array_equal(again, current)
    assert (current[~mask] == 0).all()
    with pytest.raises(NotConvergedError):
        constriction_current(mask, (1.0, 1.0), tolerance=1e-18)
