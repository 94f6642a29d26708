"""Cases on which other solvers hang, crash or claim a convergence that a fresh check denies."""

import numpy as np
import pytest

from solver import ContactProblem, Status, random_midpoint_displacement, solve
from tests.solver.conftest import PAPER_MODULUS, contact_violation

SIZE = 64
PIXEL = 1e-3 / SIZE
ROUGH = random_midpoint_displacement(SIZE, seed=1) * 50e-6
ROWS, COLUMNS = np.mgrid[:SIZE, :SIZE]
NOISE = np.random.default_rng(2).standard_normal((SIZE, SIZE)) * 1e-6


def spike(surface: np.ndarray) -> np.ndarray:
    raised = surface.copy()
    raised[20, 30] = surface.max() + 50e-6
    return raised


CASES: dict[str, dict[str, object]] = {
    "one pixel in contact": {"load": 1e-9},
    "a load lost in rounding": {"load": 1e-18},
    "seven pixels in contact": {"load": 0.5},
    "nearly full contact": {"load": 2.5e3},
    "full contact": {"load": 1e5},
    "one-pixel spike on a flat": {"heights": spike(np.zeros((SIZE, SIZE)))},
    "one-pixel spike on a rough surface": {"heights": spike(ROUGH)},
    "step of 50 um": {"heights": np.where(COLUMNS < SIZE // 2, 0.0, 50e-6)},
    "step of 50 um on a rough surface": {"heights": np.where(COLUMNS < SIZE // 2, 0.0, 50e-6) + ROUGH},
    "flat": {"heights": np.zeros((SIZE, SIZE))},
    "tilt": {"heights": COLUMNS * 1e-6},
    "slight tilt": {"heights": (COLUMNS + 0.3 * ROWS) * 1e-8},
    "checkerboard": {"heights": (COLUMNS + ROWS) % 2 * 1e-6},
    "noise": {"heights": NOISE},
    "very smooth": {"heights": 1e-6 * np.cos(2 * np.pi * COLUMNS / SIZE) * np.cos(2 * np.pi * ROWS / SIZE), "load": 1.0},
    "heights of a nanometre": {"heights": ROUGH * 2e-5, "load": 1e-3},
    "heights of a kilometre": {"heights": ROUGH * 2e7, "pixel_size": (1.0, 1.0)},
    "soft": {"effective_modulus": 1e3},
    "stiff": {"effective_modulus": 1e12},
    "tall pixels": {"pixel_size": (20 * PIXEL, PIXEL)},
    "wide pixels": {"pixel_size": (PIXEL, 20 * PIXEL)},
    "4 x 4": {"heights": NOISE[:4, :4], "load": 1e-2},
    "7 x 513": {"heights": np.random.default_rng(3).standard_normal((7, 513)) * 1e-6},
} | {f"load of 1e{exponent} N": {"load": 10.0**exponent} for exponent in range(-6, 7, 2)}


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("name", CASES)
def test_hard_case_converges_and_a_fresh_check_agrees(name: str, boundary: str) -> None:
    given = {"heights": ROUGH, "pixel_size": (PIXEL, PIXEL), "load": 30.0, "effective_modulus": PAPER_MODULUS}
    problem = ContactProblem(**(given | CASES[name]), boundary=boundary)  # type: ignore[arg-type]
    solution = solve(problem)
    assert solution.status is Status.CONVERGED
    assert contact_violation(problem, solution) < 2e-6


def test_one_pixel_carries_the_whole_of_a_tiny_load() -> None:
    solution = solve(ContactProblem(ROUGH, (PIXEL, PIXEL), 1e-9, PAPER_MODULUS))
    assert np.argwhere(solution.contact_mask).tolist() == [list(np.unravel_index(ROUGH.argmax(), ROUGH.shape))]
    assert solution.pressure.max() == pytest.approx(1e-9 / PIXEL**2)


def test_a_spike_does_not_keep_the_rest_of_the_surface_apart() -> None:
    """The deadlock of the Polonsky-Keer iteration: one pixel would carry all, thousands must."""
    solution = solve(ContactProblem(spike(np.zeros((SIZE, SIZE))), (PIXEL, PIXEL), 30.0, PAPER_MODULUS))
    assert solution.contact_mask.sum() > 3000


def test_a_periodic_flat_carries_its_nominal_pressure_everywhere() -> None:
    problem = ContactProblem(np.full((SIZE, SIZE), 3e-6), (PIXEL, PIXEL), 30.0, PAPER_MODULUS, "periodic")
    np.testing.assert_allclose(solve(problem).pressure, problem.nominal_pressure, rtol=1e-12)


def test_a_load_that_drowns_the_gap_in_rounding_is_not_called_converged() -> None:
    """Displacements of 1e17 rms heights leave float64 no digit of the gap."""
    problem = ContactProblem(ROUGH * 1e-12, (PIXEL, PIXEL), 1e9, 1e9)
    solution = solve(problem)
    assert solution.status is not Status.CONVERGED
    assert solution.residual > 1e-6
