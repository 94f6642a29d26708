"""Contact iteration: preconditioned projected conjugate gradients with one convolution a step.

The Polonsky-Keer iteration minimises 1/2 p.Kp + g0.p over the pressures p >= 0 of given sum. Written as published it can
deadlock (one pixel in contact has no gradient left) and throws its direction away whenever a pixel joins. Here pixels that
overlap join the working set before the gradient is formed; the trial step is projected onto the admissible pressures; and
the exact line search runs along the projected step, so that the energy falls in every iteration and the only convolution
is that of the step. If the conjugate direction is not one of descent, the projected gradient, which always is, replaces it.

Dimensionless: see :mod:`solver.solve`.

Source: Polonsky & Keer 1999, doi:10.1016/S0043-1648(99)00113-1.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.certificate import Certificate, certify
from solver.convolution import Convolution
from solver.preconditioner import Preconditioner
from solver.problem import BoolArray, FloatArray
from solver.solution import Status

OnIteration = Callable[[int, float], None]

PATIENCE = 250
"""Iterations without a new lowest residual after which the displacement is evaluated afresh, and then the solve ended."""

EXACT_STEP = 0.6
"""Line-search lengths from here to 1 are taken as 1, which lands on exact zeros and still lowers the energy."""


@dataclass(frozen=True, eq=False)
class Operators:
    """The linear maps of one problem."""

    convolve: Convolution
    precondition: Preconditioner


@dataclass
class _Search:
    """What the conjugate direction carries from step to step; no direction after a restart."""

    direction: FloatArray | None = None
    gradient: FloatArray | None = None
    preconditioned_norm: float = 0.0
    length: float = 0.0


def conjugate_gradients(
    operators: Operators,
    initial_gap: FloatArray,
    load: float,
    pressure: FloatArray,
    tolerance: float,
    max_iterations: int,
    on_iteration: OnIteration | None,
) -> tuple[FloatArray, FloatArray, Certificate, int, Status]:
    """Minimise the contact energy from an admissible pressure.

    Args:
        operators: displacement by pressure, and its preconditioner.
        initial_gap: undeformed gap, shape (rows, columns).
        load: what the pressures sum to.
        pressure: a start with p >= 0 and the right sum.
        tolerance: for the residual of the certificate.
        max_iterations: number of steps after which the best so far is returned.
        on_iteration: called with (iteration, residual); what it raises ends the solve and propagates.

    Returns:
        Pressure, displacement + initial gap, their fresh certificate, iterations taken, status.
    """
    separation = operators.convolve(pressure) + initial_gap
    fresh = True
    search = _Search()
    lowest, lowest_at, stalls = np.inf, 0, 0
    iteration = 0
    while True:
        certificate = certify(pressure, separation, load)
        residual = certificate.residual
        if residual < lowest:
            lowest, lowest_at, stalls = residual, iteration, 0
        stalled = iteration - lowest_at >= PATIENCE
        step = None
        if residual > tolerance and not stalled and iteration < max_iterations:
            step = _step(operators, pressure, separation, certificate.approach, load, search)
        if step is not None:
            iteration += 1
            pressure, separation = step
            fresh = False
            if on_iteration is not None:
                on_iteration(iteration, residual)
        elif not fresh:
            pressure = pressure * (load / pressure.sum())
            separation = operators.convolve(pressure) + initial_gap
            fresh = True
            search = _Search()
        elif residual <= tolerance:
            return pressure, separation, certificate, iteration, Status.CONVERGED
        elif iteration >= max_iterations:
            return pressure, separation, certificate, iteration, Status.ITERATION_LIMIT
        elif stalled and not stalls:
            lowest_at, stalls = iteration, 1
        else:
            return pressure, separation, certificate, iteration, Status.STAGNATED


def _step(
    operators: Operators,
    pressure: FloatArray,
    separation: FloatArray,
    approach: float,
    load: float,
    search: _Search,
) -> tuple[FloatArray, FloatArray] | None:
    """One step; None if rounding leaves no direction of descent."""
    working = (pressure > 0) | (separation < approach)
    gradient = np.where(working, separation - separation[working].mean(), 0.0)
    weights = operators.precondition(working.astype(np.float64), working)
    direction = _conjugate(operators.precondition, gradient, weights, working, search)
    if search.length == 0:
        curvature = float(np.vdot(direction, operators.convolve(direction)))
        if curvature <= 0:
            return None
        search.length = float(np.vdot(gradient, direction)) / curvature
    step, clipped = _projected_step(pressure, direction, search.length, load, weights)
    slope = float(np.vdot(step, gradient))
    if slope >= 0:
        direction = gradient
        step, clipped = _projected_step(pressure, direction, search.length, load, working.astype(np.float64))
        slope = float(np.vdot(step, gradient))
        if slope >= 0:
            return None
    displaced = operators.convolve(step)
    curvature = float(np.vdot(step, displaced))
    if curvature <= 0:
        return None
    optimum = -slope / curvature
    falling = step < 0
    longest = float(np.min(pressure[falling] / -step[falling], initial=np.inf))
    taken = 1.0 if EXACT_STEP <= optimum <= 1 else min(optimum, max(longest, 1.0))
    search.length *= min(max(optimum, 0.25), 4.0)
    search.gradient = gradient
    search.direction = -step if clipped else direction
    return np.maximum(pressure + taken * step, 0.0), separation + taken * displaced


def _conjugate(
    precondition: Preconditioner, gradient: FloatArray, weights: FloatArray, working: BoolArray, search: _Search
) -> FloatArray:
    """Preconditioned Polak-Ribiere direction on the working set that leaves the load as it is.

    What would change the load is taken out along the weights (the row sums of the preconditioner), which keeps the
    preconditioned gradient a direction of descent; a plain mean would not.
    """
    descent = _load_free(precondition(gradient, working), weights)
    norm = float(np.vdot(descent, gradient))
    direction = descent
    if search.direction is not None and search.gradient is not None and search.preconditioned_norm > 0:
        factor = float(np.vdot(descent, gradient - search.gradient)) / search.preconditioned_norm
        conjugate = descent + factor * _load_free(np.where(working, search.direction, 0.0), weights)
        if factor > 0 and np.vdot(conjugate, gradient) > 0:
            direction = conjugate
    search.preconditioned_norm = norm
    return direction


def _load_free(field: FloatArray, weights: FloatArray) -> FloatArray:
    """The field less that multiple of the weights which makes it sum to zero."""
    result: FloatArray = field - (field.sum() / weights.sum()) * weights
    return result


def _projected_step(
    pressure: FloatArray, direction: FloatArray, length: float, load: float, weights: FloatArray
) -> tuple[FloatArray, bool]:
    """The step from the pressure to an admissible one near pressure - length * direction, and whether it was clipped.

    Negative pressures are set to zero, and the positive ones shifted along the weights until the sum is the load; with
    equal weights this is the projection onto the admissible pressures.
    """
    trial = pressure - length * direction
    if trial.min() >= 0:
        return -length * direction, False
    positive = trial > 0
    while True:
        shift = (float(trial[positive].sum()) - load) / float(weights[positive].sum())
        remaining = positive & (trial > shift * weights)
        if np.count_nonzero(remaining) == np.count_nonzero(positive):
            return np.where(positive, trial - shift * weights, 0.0) - pressure, True
        positive = remaining
