import numpy as np
import pytest
import torch

from benchmarks.cases import midpoint_problem
from model.contact import Contact
from solver import solve


def test_the_solution_agrees_with_the_mechanics_and_what_differs_does_not() -> None:
    problem = midpoint_problem(128, 30.0)
    solution = solve(problem, tolerance=1e-9).checked()
    relative = torch.tensor(solution.pressure / solution.pressure.max(), dtype=torch.float32)

    def of(mask: np.ndarray, pressure: torch.Tensor) -> Contact:
        return Contact.of(problem, torch.where(torch.tensor(mask), 20.0, -20.0), pressure)

    right = of(solution.contact_mask, relative)
    np.testing.assert_array_equal(right.mask, solution.contact_mask)
    assert right.pressure.sum() * problem.pixel_area == pytest.approx(problem.load)
    assert right.disagreement() < 0.005

    spots = solution.contact_mask.copy()
    spots[:64] = False
    missed = of(spots, relative)
    moved = of(np.roll(solution.contact_mask, 5, axis=1), relative.roll(5, dims=1))
    assert 0.1 < missed.disagreement() <= 1
    assert 0.5 < moved.disagreement() <= 1
