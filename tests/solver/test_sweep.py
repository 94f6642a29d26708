import numpy as np
import pytest

from solver import ContactProblem, Status, random_midpoint_displacement, solve
from solver.errors import InvalidLoadError
from solver.sweep import solve_sweep
from tests.solver.conftest import PAPER_MODULUS, contact_violation

PROBLEM = ContactProblem(random_midpoint_displacement(64, seed=1) * 50e-6, (1e-3 / 64, 1e-3 / 64), 1.0, PAPER_MODULUS)


def test_a_sweep_is_its_loads_one_by_one() -> None:
    """In ascending order, each as solved alone; close loads, distant ones, and one twice."""
    loads = [30.0, 10.0, 12.0, 14.0, 14.0, 200.0]
    swept = list(solve_sweep(PROBLEM, loads, tolerance=1e-9))
    assert [load for load, _ in swept] == sorted(loads)
    for load, solution in swept:
        alone = ContactProblem(PROBLEM.heights, PROBLEM.pixel_size, load, PAPER_MODULUS)
        assert solution.status is Status.CONVERGED
        assert contact_violation(alone, solution) < 2e-9
        np.testing.assert_array_equal(solution.contact_mask, solve(alone, tolerance=1e-9).contact_mask)


def test_close_loads_take_fewer_iterations_than_alone() -> None:
    loads = np.linspace(20, 40, 9)
    swept = sum(solution.iterations for _, solution in solve_sweep(PROBLEM, loads))  # type: ignore[arg-type]
    alone = sum(solve(ContactProblem(PROBLEM.heights, PROBLEM.pixel_size, load, PAPER_MODULUS)).iterations for load in loads)
    assert swept < 0.9 * alone


@pytest.mark.parametrize("loads", [[], [10.0, 0.0], [float("inf")]])
def test_loads_are_positive_and_there_is_one(loads: list[float]) -> None:
    with pytest.raises(InvalidLoadError):
        list(solve_sweep(PROBLEM, loads))
