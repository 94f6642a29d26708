import numpy as np
import pytest

from solver import ContactProblem
from solver.coarsening import coarsened, prolonged

HEIGHTS = np.random.default_rng(0).random((10, 13)) * 1e-6


def test_coarse_heights_are_block_means_and_the_load_stays() -> None:
    problem = ContactProblem(HEIGHTS, (1e-6, 2e-6), 3.0, 1e9, "periodic")
    coarse = coarsened(problem, 2)
    assert coarse.shape == (5, 7)
    assert coarse.heights[1, 2] == pytest.approx(HEIGHTS[2:4, 4:6].mean())
    assert coarse.heights[1, 6] == pytest.approx(HEIGHTS[2:4, 12].mean())
    assert coarse.pixel_size == (2e-6, 4e-6)
    assert (coarse.load, coarse.effective_modulus, coarse.boundary) == (3.0, 1e9, "periodic")


def test_prolongation_repeats() -> None:
    fine = prolonged(np.arange(6.0).reshape(2, 3), 2, (4, 5))
    assert fine.tolist() == [[0, 0, 1, 1, 2], [0, 0, 1, 1, 2], [3, 3, 4, 4, 5], [3, 3, 4, 4, 5]]
