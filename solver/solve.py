"""Solve a contact problem: make it dimensionless, iterate, certify, return to SI units."""

from typing import Literal

import numpy as np

from solver.conjugate_gradients import OnIteration, Operators, conjugate_gradients
from solver.convolution import convolution
from solver.errors import InvalidProblemError
from solver.preconditioner import preconditioner
from solver.problem import ContactProblem, FloatArray
from solver.solution import Solution

Method = Literal["fft"]


def solve(
    problem: ContactProblem,
    method: Method = "fft",
    tolerance: float = 1e-6,
    initial_pressure: FloatArray | None = None,
    on_iteration: OnIteration | None = None,
    max_iterations: int = 10_000,
) -> Solution:
    """Pressure and gap of a frictionless elastic contact.

    Args:
        problem: heights, pixel size, load, effective modulus and boundary.
        method: how the displacement is evaluated: ``fft``, the exact convolution.
        tolerance: for the residual of the certificate, dimensionless: complementarity and penetration relative to the
            rms height (to the mean displacement under the nominal pressure if the surface is flat), and load balance.
        initial_pressure: a start in Pa, shape (rows, columns); negative values are dropped and the load restored.
            Without it the pressure starts uniform.
        on_iteration: called each iteration with (iteration, residual); what it raises ends the solve and propagates.
        max_iterations: after these the best so far is returned, with the status that says so.

    Returns:
        The solution. Its status, decided by a certificate from a fresh convolution, says whether it converged.

    Raises:
        InvalidProblemError: unknown method, tolerance not positive, or an initial pressure of the wrong shape.
    """
    if method != "fft":
        raise InvalidProblemError(f"The method is {method!r}; it must be 'fft'.")
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise InvalidProblemError(f"The tolerance is {tolerance:g}; it must be positive and finite.")

    # Units: length s = sqrt(dx dy), gap H = rms height, pressure E* H / s.
    operators = Operators(
        convolution(problem.boundary, problem.shape, problem.pixel_size), preconditioner(problem.pixel_size)
    )
    length = float(np.sqrt(problem.pixel_area))
    height = problem.rms_height or problem.load / (problem.effective_modulus * np.sqrt(problem.nominal_area))
    pressure_unit = problem.effective_modulus * height / length
    load = problem.load / (problem.pixel_area * pressure_unit)

    pressure, separation, certificate, iterations, status = conjugate_gradients(
        operators,
        problem.initial_gap / height,
        load,
        _admissible_start(problem, load, initial_pressure),
        tolerance,
        max_iterations,
        on_iteration,
    )
    return Solution(
        pressure=pressure * pressure_unit,
        gap=(separation - certificate.approach) * height,
        approach=certificate.approach * height,
        iterations=iterations,
        status=status,
        residual=certificate.residual,
    )


def _admissible_start(problem: ContactProblem, load: float, initial_pressure: FloatArray | None) -> FloatArray:
    """A dimensionless pressure that is non-negative and sums to the load."""
    if initial_pressure is None:
        return np.full(problem.shape, load / problem.heights.size)
    if initial_pressure.shape != problem.shape or not np.isfinite(initial_pressure).all():
        raise InvalidProblemError(
            f"The initial pressure has shape {initial_pressure.shape}; it must be finite and of shape {problem.shape}."
        )
    start = np.maximum(initial_pressure, 0.0)
    if start.sum() == 0:
        raise InvalidProblemError("The initial pressure is nowhere positive.")
    start *= load / start.sum()
    return start
