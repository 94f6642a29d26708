"""Solve contact problems: make them dimensionless, start from a coarser grid, iterate, certify, return to SI units."""

from collections.abc import Sequence
from typing import get_args

import numpy as np

from solver.arrays import Device, moved, on_processor
from solver.conjugate_gradients import OnIteration
from solver.errors import InvalidProblemError
from solver.operators import Method, Operators
from solver.problem import ContactProblem, FloatArray
from solver.refinement import admissible, cascade, refine
from solver.solution import Solution

MOST_ITERATIONS = 10_000


def solve(
    problem: ContactProblem,
    method: Method = "fft",
    tolerance: float = 1e-6,
    initial_pressure: FloatArray | None = None,
    on_iteration: OnIteration | None = None,
    max_iterations: int = MOST_ITERATIONS,
) -> Solution:
    """Pressure and gap of a frictionless elastic contact.

    Args:
        problem: heights, pixel size, load, effective modulus and boundary.
        method: how the displacement that decides is evaluated: ``fft``, by the exact convolution, or ``multilevel``, by
            sums over tiles, without a Fourier transform, on a free boundary.
        tolerance: for the residual of the certificate, dimensionless: complementarity and penetration relative to the
            rms height (to the mean displacement under the nominal pressure if the surface is flat), and load balance.
        initial_pressure: a start in Pa, shape (rows, columns); negative values are dropped and the load restored.
            Without it the pressure starts from that of a coarser grid.
        on_iteration: called each iteration with (iteration, residual), iteration 0 for those of coarser grids; what it
            raises ends the solve and propagates.
        max_iterations: after these the best pressure is returned, with the status that says so.

    Returns:
        The solution. Its status, decided by a certificate from a fresh evaluation, says whether it converged.

    Raises:
        InvalidProblemError: unknown method, a periodic boundary with ``multilevel``, tolerance not positive, or an initial
            pressure of the wrong shape.
    """
    starts = None if initial_pressure is None else [initial_pressure]
    return solve_batch([problem], method, tolerance, starts, on_iteration, max_iterations)[0]


def solve_batch(
    problems: Sequence[ContactProblem],
    method: Method = "fft",
    tolerance: float = 1e-6,
    initial_pressures: Sequence[FloatArray] | None = None,
    on_iteration: OnIteration | None = None,
    max_iterations: int = MOST_ITERATIONS,
    device: Device = None,
) -> list[Solution]:
    """Solve problems of one shape, pixel size and boundary side by side, each as :func:`solve` would.

    Args:
        problems: one or more.
        method, tolerance, initial_pressures, on_iteration, max_iterations: as for :func:`solve`; the residual reported is
            the largest.
        device: of torch, such as ``cuda``, to run on; None for the processor, by NumPy.

    Raises:
        InvalidProblemError: as :func:`solve`, and for problems that differ in shape, pixel size or boundary.
    """
    _check(problems, method, tolerance)
    first = problems[0]
    aspect = first.pixel_size[0] / first.pixel_size[1]
    operators = Operators(method, first.boundary, first.shape, (aspect, 1.0), device)  # kept for maps of all pixel sizes

    # Units: length s = sqrt(dx dy), gap H = rms height, pressure E* H / s.
    length = float(np.sqrt(first.pixel_area))
    heights = [one.rms_height or one.load / (one.effective_modulus * np.sqrt(one.nominal_area)) for one in problems]
    units = [one.effective_modulus * height / length for one, height in zip(problems, heights, strict=True)]
    gaps = [one.initial_gap / height for one, height in zip(problems, heights, strict=True)]
    loads = np.array([one.load / (one.pixel_area * unit) for one, unit in zip(problems, units, strict=True)])

    gap, load = moved(np.stack(gaps), device), moved(loads, device)
    cap = None
    if any(one.hardness for one in problems):
        cap = moved(np.array([(one.hardness or np.inf) / unit for one, unit in zip(problems, units, strict=True)]), device)
    if initial_pressures is None:
        start = cascade(operators, gap, load, cap, on_iteration)
    else:
        starts = [_checked_start(one, pressure) for one, pressure in zip(problems, initial_pressures, strict=True)]
        start = admissible(moved(np.stack(starts), device), load, cap)
    refined = refine(operators, gap, load, cap, start, tolerance, max_iterations, on_iteration)
    return [
        Solution(
            pressure=on_processor(one.pressure) * unit,
            gap=(on_processor(one.separation) - one.approach) * height,
            approach=one.approach * height,
            iterations=one.iterations,
            status=one.status,
            residual=one.residual,
        )
        for one, height, unit in zip(refined, heights, units, strict=True)
    ]


def _check(problems: Sequence[ContactProblem], method: str, tolerance: float) -> None:
    if method not in get_args(Method):
        raise InvalidProblemError(f"The method is {method!r}; it must be 'fft' or 'multilevel'.")
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise InvalidProblemError(f"The tolerance is {tolerance:g}; it must be positive and finite.")
    kinds = {(problem.shape, problem.pixel_size, problem.boundary) for problem in problems}
    if len(kinds) != 1:
        raise InvalidProblemError(
            f"The {len(problems)} problems have {len(kinds)} different shapes, pixel sizes or boundaries; a batch has one."
        )
    if method == "multilevel" and problems[0].boundary == "periodic":
        raise InvalidProblemError("The multilevel method needs the free boundary; use 'fft' for the periodic one.")


def _checked_start(problem: ContactProblem, initial_pressure: FloatArray) -> FloatArray:
    """An initial pressure that is nowhere negative and somewhere positive."""
    if initial_pressure.shape != problem.shape or not np.isfinite(initial_pressure).all():
        raise InvalidProblemError(
            f"The initial pressure has shape {initial_pressure.shape}; it must be finite and of shape {problem.shape}."
        )
    start = np.maximum(initial_pressure, 0.0)
    if start.sum() == 0:
        raise InvalidProblemError("The initial pressure is nowhere positive.")
    start /= start.max()
    return start
