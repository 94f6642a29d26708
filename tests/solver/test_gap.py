import numpy as np
import pytest

from benchmarks.cases import midpoint_problem
from solver import ContactProblem, solve
from solver.gap import gap_under
from solver.problem import Boundary


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("pixel_size", [(2e-6, 2e-6), (1e-6, 3e-6)])
def test_the_pressure_of_a_solution_leaves_the_gap_of_the_solution(
    boundary: Boundary, pixel_size: tuple[float, float]
) -> None:
    heights = midpoint_problem(64, 30.0).heights
    problem = ContactProblem(heights, pixel_size, 1e-2, 7e9, boundary)
    solution = solve(problem, tolerance=1e-9).checked()
    np.testing.assert_allclose(gap_under(problem, solution.pressure), solution.gap, atol=1e-5 * np.ptp(heights))


def test_too_much_pressure_at_one_place_parts_the_bodies_there_and_they_overlap_elsewhere() -> None:
    problem = midpoint_problem(64, 30.0)
    solution = solve(problem).checked()
    row, column = np.unravel_index(solution.pressure.argmax(), problem.shape)
    pressure = solution.pressure.copy()
    pressure[row, column] *= 3
    gap = gap_under(problem, pressure)
    assert gap[row, column] > 0
    assert gap[solution.contact_mask].min() < 0
    assert np.average(gap, weights=pressure) == pytest.approx(0, abs=1e-12 * np.ptp(problem.heights))
