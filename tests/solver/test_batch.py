"""Batches: many surfaces side by side, on NumPy or torch, as one after another."""

import numpy as np
import pytest

from solver import ContactProblem, InvalidProblemError, Solution, Status, random_midpoint_displacement, solve
from solver.operators import Method
from solver.problem import Boundary
from solver.solve import solve_batch
from tests.solver.conftest import PAPER_MODULUS, contact_violation


def problems(boundary: Boundary, hardness: float | None = None, size: int = 48) -> list[ContactProblem]:
    """Surfaces of very different heights, moduli and loads; the lightest is done long before the heaviest."""
    rough = [
        random_midpoint_displacement(64, seed=seed)[:size, :40] * height for seed, height in enumerate((5e-5, 1e-6, 1e-3))
    ]
    given = zip(rough, (0.1, 30.0, 400.0), (PAPER_MODULUS, 1e10, 1e8), strict=True)
    return [ContactProblem(h, (2e-5, 1.5e-5), load, modulus, boundary, hardness) for h, load, modulus in given]


def assert_same(ours: list[Solution], alone: list[Solution]) -> None:
    for one, other in zip(ours, alone, strict=True):
        assert one.status is other.status is Status.CONVERGED
        np.testing.assert_array_equal(one.contact_mask, other.contact_mask)
        assert one.approach == pytest.approx(other.approach, rel=1e-7)


@pytest.mark.parametrize(("boundary", "method"), [("free", "fft"), ("periodic", "fft"), ("free", "multilevel")])
@pytest.mark.parametrize("hardness", [None, 2e9])
def test_a_batch_is_its_problems_one_by_one(boundary: Boundary, method: Method, hardness: float | None) -> None:
    batch = problems(boundary, hardness)
    assert_same(solve_batch(batch, method, 1e-7), [solve(problem, method, 1e-7) for problem in batch])


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("hardness", [None, 2e9])
def test_a_device_of_torch_gives_what_numpy_gives(boundary: Boundary, hardness: float | None) -> None:
    """torch's processor stands for any accelerator: the code is the same."""
    batch = problems(boundary, hardness)
    there = solve_batch(batch, tolerance=1e-8, device="cpu")
    assert_same(there, solve_batch(batch, tolerance=1e-8))
    for problem, solution in zip(batch, there, strict=True):
        assert isinstance(solution.pressure, np.ndarray)
        if hardness is None:
            assert contact_violation(problem, solution) < 2e-8


def test_a_device_starts_large_maps_from_coarse_ones() -> None:
    problem = ContactProblem(random_midpoint_displacement(128, seed=1) * 5e-5, (1e-5, 1e-5), 30.0, PAPER_MODULUS)
    assert_same(solve_batch([problem], tolerance=1e-8, device="cpu"), [solve(problem, tolerance=1e-8)])


def test_the_loads_balance_to_rounding() -> None:
    batch = problems("free")
    for problem, solution in zip(batch, solve_batch(batch), strict=True):
        assert solution.pressure.sum() * problem.pixel_area == pytest.approx(problem.load, rel=1e-12)


def test_each_problem_of_a_batch_has_its_own_end() -> None:
    batch = problems("free")
    limited = solve_batch(batch, max_iterations=12)
    assert {solution.status for solution in limited} == {Status.CONVERGED, Status.ITERATION_LIMIT}
    for solution in limited:
        assert solution.converged == (solution.residual <= 1e-6)


@pytest.mark.parametrize(
    "other",
    [{"heights": np.eye(5)}, {"pixel_size": (1.0, 2.0)}, {"boundary": "periodic"}],
)
def test_the_problems_of_a_batch_have_one_grid(other: dict[str, object]) -> None:
    given = {"heights": np.eye(4), "pixel_size": (1.0, 1.0), "load": 1.0, "effective_modulus": 1.0, "boundary": "free"}
    with pytest.raises(InvalidProblemError):
        solve_batch([ContactProblem(**given), ContactProblem(**given | other)])  # type: ignore[arg-type]
