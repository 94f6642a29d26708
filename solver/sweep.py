"""One surface under many loads, each solve started from those before it."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from solver.errors import InvalidLoadError
from solver.operators import Method
from solver.problem import ContactProblem, FloatArray
from solver.solution import Solution
from solver.solve import solve

CLOSE_LOADS = 1.6
"""Ratio of a load to the one before up to which extrapolation is a better start than a coarser grid: it saves a third of
the iterations at a ratio of 1.2, and costs some at 2."""


def solve_sweep(
    problem: ContactProblem, loads: Sequence[float], method: Method = "fft", tolerance: float = 1e-6
) -> Iterator[tuple[float, Solution]]:
    """Solve a problem under several loads, from the lightest to the heaviest.

    Args:
        problem: surface and material; its own load does not matter.
        loads: in N, at least one, in any order.
        method, tolerance: as for :func:`solver.solve.solve`.

    Yields:
        Each load with its solution as soon as it is there, lightest first.

    Raises:
        InvalidLoadError: no load, or one that is not positive and finite or that the hardness does not bear.
    """
    if len(loads) == 0:
        raise InvalidLoadError("There is no load to solve for; give one or more.")
    problems = [replace(problem, load=load) for load in sorted(loads)]
    done: list[tuple[float, FloatArray]] = []
    for one in problems:
        solution = solve(one, method, tolerance, _extrapolated(done, one.load))
        done = [*done[-1:], (one.load, solution.pressure)]
        yield one.load, solution


def _extrapolated(done: list[tuple[float, FloatArray]], load: float) -> FloatArray | None:
    """The pressure that two lighter loads lead to expect, linearly; None where they are too few or too far apart."""
    if len(done) < 2 or load > CLOSE_LOADS * done[1][0]:
        return None
    (first, lighter), (second, heavier) = done
    if second == first:
        return heavier
    expected: FloatArray = heavier + (heavier - lighter) * ((load - second) / (second - first))
    return np.maximum(expected, 0.0) if (expected > 0).any() else None
