"""Cases on which other solvers hang, crash or claim a convergence that a fresh check denies."""

import numpy as np
import pytest

from benchmarks.cases import HOPELESS, PIXEL, REFUSED, ROUGH, SIZE, SOLVABLE, USUAL, spike
from solver import ContactProblem, InvalidProblemError, Status, solve
from solver.closed_forms import SQUARE_PUNCH_STIFFNESS
from solver.operators import Method
from tests.solver.conftest import PAPER_MODULUS, contact_violation

BEYOND_MULTILEVEL = {"E* of 1 kPa", "load of 1e+6 N"}
"""Displacements so large beside the heights that the error of the multilevel sum is not small beside the gap."""


@pytest.mark.parametrize(("method", "boundary"), [("fft", "free"), ("fft", "periodic"), ("multilevel", "free")])
@pytest.mark.parametrize("name", SOLVABLE)
def test_hard_case_converges_and_a_fresh_check_agrees(name: str, method: Method, boundary: str) -> None:
    problem = ContactProblem(**USUAL | SOLVABLE[name] | {"boundary": boundary})
    solution = solve(problem, method)
    if method == "multilevel" and name in BEYOND_MULTILEVEL:
        assert solution.status is Status.STAGNATED
        return
    assert solution.status is Status.CONVERGED
    assert contact_violation(problem, solution) < 2e-6


@pytest.mark.parametrize("name", REFUSED)
def test_a_problem_without_an_answer_is_refused(name: str) -> None:
    with pytest.raises(InvalidProblemError):
        ContactProblem(**USUAL | REFUSED[name])


@pytest.mark.parametrize("method", ["fft", "multilevel"])
@pytest.mark.parametrize("name", HOPELESS)
def test_a_tolerance_that_no_double_reaches_is_not_called_converged(name: str, method: Method) -> None:
    change, tolerance = HOPELESS[name]
    problem = ContactProblem(**USUAL | change)
    solution = solve(problem, method, tolerance)
    assert solution.status is not Status.CONVERGED
    assert solution.residual > tolerance
    assert solution.pressure.sum() * problem.pixel_area == pytest.approx(problem.load, rel=1e-12)


def test_one_pixel_carries_the_whole_of_a_tiny_load() -> None:
    solution = solve(ContactProblem(**USUAL | {"load": 1e-9}))
    assert np.argwhere(solution.contact_mask).tolist() == [list(np.unravel_index(ROUGH.argmax(), ROUGH.shape))]
    assert solution.pressure.max() == pytest.approx(1e-9 / PIXEL**2)


def test_a_spike_does_not_keep_the_rest_of_the_surface_apart() -> None:
    """The deadlock of the Polonsky-Keer iteration: one pixel would carry all, thousands must."""
    solution = solve(ContactProblem(**USUAL | {"heights": spike(np.zeros((SIZE, SIZE)))}))
    assert solution.contact_mask.sum() > 3000


def test_a_periodic_flat_carries_its_nominal_pressure_everywhere() -> None:
    problem = ContactProblem(np.full((SIZE, SIZE), 3e-6), (PIXEL, PIXEL), 30.0, PAPER_MODULUS, "periodic")
    np.testing.assert_allclose(solve(problem).pressure, problem.nominal_pressure, rtol=1e-12)


def test_a_free_flat_is_a_square_punch() -> None:
    problem = ContactProblem(**USUAL | {"heights": np.zeros((SIZE, SIZE))})
    stiffness = problem.load / (PAPER_MODULUS * 1e-3 * solve(problem).approach)
    assert stiffness == pytest.approx(SQUARE_PUNCH_STIFFNESS, rel=0.02)


@pytest.mark.timeout(30)
@pytest.mark.parametrize("size", [32, 128])
def test_what_no_number_can_hold_ends_and_says_so(size: int) -> None:
    heights = np.random.default_rng(1).random((size, size)) * 1e-156
    solution = solve(ContactProblem(heights, (1e14, 1e14), 1e30, PAPER_MODULUS))
    assert not solution.converged
