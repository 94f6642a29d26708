"""An independent check of a solution: benchmarks/certificates.py, which shares nothing with the solver."""

import numpy as np

from benchmarks.certificates import displacement, violation
from solver import ContactProblem, Solution

PAPER_MODULUS = 6.843e9


def fresh_gap(problem: ContactProblem, solution: Solution) -> np.ndarray:
    """The gap that the pressure of a solution leaves at its approach, in m."""
    return displacement(problem, solution.pressure) + problem.initial_gap - solution.approach


def contact_violation(problem: ContactProblem, solution: Solution) -> float:
    """Largest of: sum p |g| / (F height scale), deepest penetration / height scale, load imbalance."""
    assert (solution.pressure >= 0).all()
    return violation(problem, solution.pressure)
