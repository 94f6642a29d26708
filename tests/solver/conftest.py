"""An independent check of a solution: its own influence coefficients, its own convolution, its own conditions."""

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from scipy.signal import fftconvolve

from solver import ContactProblem, Solution

PAPER_MODULUS = 6.843e9


def love(dy: float, dx: float, rows: int, columns: int) -> np.ndarray:
    """Love's rectangle formula (Johnson, Eq. 3.25) for all distances from -rows + 1 to rows - 1, in 1 / E*."""
    y, x = np.meshgrid(np.arange(1 - rows, rows) * dy, np.arange(1 - columns, columns) * dx, indexing="ij")
    total = np.zeros_like(x)
    for sign_y, sign_x in product((1, -1), (1, -1)):
        v, u = y + sign_y * dy / 2, x + sign_x * dx / 2
        total += sign_y * sign_x * (u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v)))
    return total / np.pi


def displacement(problem: ContactProblem, pressure: np.ndarray) -> np.ndarray:
    dy, dx = problem.pixel_size
    rows, columns = problem.shape
    if problem.boundary == "free":
        full = fftconvolve(pressure, love(dy, dx, rows, columns))
        return full[rows - 1 : 2 * rows - 1, columns - 1 : 2 * columns - 1] / problem.effective_modulus
    q = 2 * np.pi * np.hypot(*np.meshgrid(np.fft.fftfreq(rows, dy), np.fft.fftfreq(columns, dx), indexing="ij"))
    q[0, 0] = np.inf
    return np.fft.ifft2(np.fft.fft2(pressure) * 2 / q).real / problem.effective_modulus


def fresh_gap(problem: ContactProblem, solution: Solution) -> np.ndarray:
    """The gap that the pressure of a solution leaves at its approach, in m."""
    return displacement(problem, solution.pressure) + problem.initial_gap - solution.approach


def contact_violation(problem: ContactProblem, solution: Solution) -> float:
    """Largest of: sum p |g| / (F height scale), deepest penetration / height scale, load imbalance."""
    pressure = solution.pressure
    assert (pressure >= 0).all()
    separation = displacement(problem, pressure) - problem.heights
    gap = separation - np.average(separation, weights=pressure)
    scale = problem.rms_height or problem.load / (problem.effective_modulus * np.sqrt(problem.nominal_area))
    complementarity = (pressure * np.abs(gap)).sum() / pressure.sum() / scale
    imbalance = abs(pressure.sum() * problem.pixel_area / problem.load - 1)
    return float(max(complementarity, -gap.min() / scale, imbalance))


@pytest.fixture
def violation() -> Callable[[ContactProblem, Solution], float]:
    return contact_violation
