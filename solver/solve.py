"""Solve a contact problem: make it dimensionless, start it from a coarser grid, iterate, certify, return to SI units."""

from typing import Literal

import numpy as np

from solver.candidates import Candidates
from solver.certificate import Certificate, certify
from solver.coarsening import coarsened, prolonged
from solver.conjugate_gradients import OnIteration, descend
from solver.convolution import Precision, convolution
from solver.errors import InvalidProblemError
from solver.problem import ContactProblem, FloatArray
from solver.solution import Solution, Status

Method = Literal["fft"]

COLD_START_SIDE = 64
"""Pixels a side up to which the pressure starts uniform; larger maps start from the solution of one twice as coarse."""

COARSE_TOLERANCE = 1e-2

CANDIDATE_GAP = 0.03
"""Pixels with gaps below this, in rms heights, may come into contact; a check of all pixels adds what was missed."""

INNER_SHARE = 0.5
"""Share of the tolerance to which the pressures on the candidates are brought before all pixels are checked."""


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
            Without it the pressure starts from that of a coarser grid.
        on_iteration: called each iteration with (iteration, residual); what it raises ends the solve and propagates.
        max_iterations: after these the last pressure is returned, with the status that says so.

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
    length = float(np.sqrt(problem.pixel_area))
    height = problem.rms_height or problem.load / (problem.effective_modulus * np.sqrt(problem.nominal_area))
    pressure_unit = problem.effective_modulus * height / length
    load = problem.load / (problem.pixel_area * pressure_unit)
    start = _start(problem) if initial_pressure is None else _checked_start(problem, initial_pressure)
    start *= load / start.sum()

    pressure, separation, certificate, iterations, status = _refine(
        problem, problem.initial_gap / height, load, start, tolerance, max_iterations, on_iteration
    )
    return Solution(
        pressure=pressure * pressure_unit,
        gap=(separation - certificate.approach) * height,
        approach=certificate.approach * height,
        iterations=iterations,
        status=status,
        residual=certificate.residual,
    )


def _refine(
    problem: ContactProblem,
    initial_gap: FloatArray,
    load: float,
    pressure: FloatArray,
    tolerance: float,
    max_iterations: int,
    on_iteration: OnIteration | None,
) -> tuple[FloatArray, FloatArray, Certificate, int, Status]:
    """Descend on the candidates in single precision, check all pixels in double precision, and so on until it holds.

    A pass that neither adds candidates nor halves the residual gives way to descents on all pixels in double precision;
    if those do not help either, rounding is in the way.

    Returns:
        Pressure, displacement + initial gap, their fresh certificate, iterations taken, status.
    """
    convolve = convolution(problem.boundary, problem.shape, problem.pixel_size)
    precision: Precision = "float32"
    mask = np.zeros(problem.shape, dtype=np.bool_)
    iterations, lowest = 0, np.inf
    while True:
        separation = convolve(pressure) + initial_gap
        certificate = certify(pressure, separation, load)
        if certificate.residual <= tolerance:
            return pressure, separation, certificate, iterations, Status.CONVERGED
        if iterations >= max_iterations:
            return pressure, separation, certificate, iterations, Status.ITERATION_LIMIT
        grown = mask | (pressure > 0) | (separation - certificate.approach < CANDIDATE_GAP)
        if certificate.residual > lowest / 2 and np.array_equal(grown, mask):
            if precision == "float64":
                return pressure, separation, certificate, iterations, Status.STAGNATED
            precision = "float64"
            grown[:] = True
        lowest, mask = min(lowest, certificate.residual), grown
        candidates = Candidates(
            mask, problem.pixel_size, convolution(problem.boundary, problem.shape, problem.pixel_size, precision)
        )
        values, iterations = descend(
            candidates,
            candidates.gather(pressure),
            candidates.gather(separation),
            load,
            INNER_SHARE * tolerance,
            range(iterations + 1, max_iterations + 1),
            on_iteration,
        )
        pressure = candidates.scatter(values * (load / values.sum()))


def _start(problem: ContactProblem) -> FloatArray:
    """The pressure of the problem on pixels twice as large, loosely solved; uniform where the map is small.

    How the coarse solve ended does not matter: any pressure is a start.
    """
    if max(problem.shape) <= COLD_START_SIDE or min(problem.shape) < COLD_START_SIDE // 2:
        return np.ones(problem.shape)
    coarse = solve(coarsened(problem, 2), tolerance=COARSE_TOLERANCE)
    return prolonged(coarse.pressure, 2, problem.shape)


def _checked_start(problem: ContactProblem, initial_pressure: FloatArray) -> FloatArray:
    """An initial pressure that is nowhere negative and somewhere positive."""
    if initial_pressure.shape != problem.shape or not np.isfinite(initial_pressure).all():
        raise InvalidProblemError(
            f"The initial pressure has shape {initial_pressure.shape}; it must be finite and of shape {problem.shape}."
        )
    start = np.maximum(initial_pressure, 0.0)
    if start.sum() == 0:
        raise InvalidProblemError("The initial pressure is nowhere positive.")
    return start
