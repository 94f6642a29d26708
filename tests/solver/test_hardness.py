"""Elastic, perfectly plastic contact: pressures below a hardness."""

from dataclasses import replace

import numpy as np
import pytest

from solver import ContactProblem, Status, random_midpoint_displacement, solve
from solver.errors import InvalidLoadError, InvalidMaterialError
from tests.solver.conftest import PAPER_MODULUS, fresh_gap

SIZE = 64


def rough(hardness: float | None, boundary: str = "free", load: float = 30.0) -> ContactProblem:
    heights = random_midpoint_displacement(SIZE, seed=1) * 50e-6
    return ContactProblem(heights, (1e-3 / SIZE, 1e-3 / SIZE), load, PAPER_MODULUS, boundary, hardness)  # type: ignore[arg-type]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("hardness", [4e7, 3e8, 1e9])
def test_contact_conditions_with_a_hardness(hardness: float, boundary: str) -> None:
    """Gaps close where the pressure is between the bounds, are open where it is zero, overlap where it is the hardness."""
    problem = rough(hardness, boundary)
    solution = solve(problem)
    assert solution.status is Status.CONVERGED
    pressure = solution.pressure
    assert pressure.max() <= hardness * (1 + 1e-12)
    assert pressure.sum() * problem.pixel_area == pytest.approx(problem.load, rel=1e-12)
    gap = fresh_gap(problem, solution) / problem.rms_height
    flowing, free = pressure > hardness * (1 - 1e-9), pressure == 0
    elastic = ~flowing & ~free
    assert flowing.any()
    assert elastic.any()
    assert gap[flowing].max() < 1e-4
    assert gap[free].min() > -2e-6
    assert np.average(np.abs(gap[elastic]), weights=pressure[elastic]) < 2e-5


def test_a_hardness_that_is_not_reached_changes_nothing() -> None:
    elastic = solve(rough(None), tolerance=1e-9)
    hard = solve(rough(1.1 * elastic.pressure.max()), tolerance=1e-9)
    np.testing.assert_array_equal(hard.contact_mask, elastic.contact_mask)
    np.testing.assert_allclose(hard.pressure, elastic.pressure, atol=1e-5 * elastic.pressure.max())


def test_a_soft_surface_touches_on_load_over_hardness() -> None:
    """Nearly all of the contact flows, so that the area is the load over the hardness (Bowden & Tabor 1939)."""
    problem = rough(1e8)
    solution = solve(problem)
    assert solution.contact_fraction == pytest.approx(problem.nominal_pressure / 1e8, rel=0.05)


def test_softer_surfaces_touch_more() -> None:
    fractions = [solve(rough(hardness)).contact_fraction for hardness in (None, 2e9, 1e9, 3e8, 1e8, 4e7)]
    assert fractions == sorted(fractions)
    assert fractions[0] < fractions[-1]


def test_one_pixel_of_a_spike_flows_and_the_rest_carries() -> None:
    heights = np.zeros((SIZE, SIZE))
    heights[20, 30] = 50e-6
    problem = replace(rough(1e9), heights=heights)
    solution = solve(problem)
    assert solution.status is Status.CONVERGED
    assert solution.pressure[20, 30] == pytest.approx(1e9)
    assert solution.contact_mask.sum() > 3000


@pytest.mark.parametrize("hardness", [0.0, -1e9, float("nan"), float("inf")])
def test_a_hardness_is_positive_and_finite(hardness: float) -> None:
    with pytest.raises(InvalidMaterialError, match="hardness"):
        rough(hardness)


def test_a_load_that_the_surface_cannot_bear_is_refused() -> None:
    with pytest.raises(InvalidLoadError, match="bears less than 10 N"):
        rough(1e7)
