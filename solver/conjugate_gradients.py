"""Contact iteration: projected conjugate gradients with one convolution a step.

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
from solver.problem import BoolArray, FloatArray
from solver.solution import Status

OnIteration = Callable[[int, float], None]

PATIENCE = 250
"""Iterations without a new lowest residual after which the displacement is evaluated afresh, and then the solve ended."""

EXACT_STEP = 0.6
"""Line-search lengths from here to 1 are taken as 1, which lands on exact zeros and still lowers the energy."""


@dataclass
class _Search:
    """The conjugate direction, carried from step to step; None after a restart."""

    direction: FloatArray | None = None
    gradient: FloatArray | None = None
    length: float = 0.0


def conjugate_gradients(
    convolve: Convolution,
    initial_gap: FloatArray,
    load: float,
    pressure: FloatArray,
    tolerance: float,
    max_iterations: int,
    on_iteration: OnIteration | None,
) -> tuple[FloatArray, FloatArray, Certificate, int, Status]:
    """Minimise the contact energy from an admissible pressure.

    Args:
        convolve: displacement by pressure.
        initial_gap: undeformed gap, shape (rows, columns).
        load: what the pressures sum to.
        pressure: a start with p >= 0 and the right sum.
        tolerance: for the residual of the certificate.
        max_iterations: number of steps after which the best so far is returned.
        on_iteration: called with (iteration, residual); what it raises ends the solve and propagates.

    Returns:
        Pressure, displacement + initial gap, their fresh certificate, iterations taken, status.
    """
    separation = convolve(pressure) + initial_gap
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
        ended = residual <= tolerance or stalled or iteration >= max_iterations
        if ended and not fresh:
            pressure = pressure * (load / pressure.sum())
            separation = convolve(pressure) + initial_gap
            fresh = True
            search = _Search()
            continue
        if residual <= tolerance:
            return pressure, separation, certificate, iteration, Status.CONVERGED
        if iteration >= max_iterations:
            return pressure, separation, certificate, iteration, Status.ITERATION_LIMIT
        if stalled and stalls:
            return pressure, separation, certificate, iteration, Status.STAGNATED
        if stalled:
            lowest_at, stalls = iteration, 1
        iteration += 1
        if on_iteration is not None:
            on_iteration(iteration, residual)
        step = _step(convolve, pressure, separation, certificate.approach, load, search)
        if step is None:
            if fresh:
                return pressure, separation, certificate, iteration, Status.STAGNATED
            separation = convolve(pressure) + initial_gap
            fresh = True
            search = _Search()
            continue
        pressure, separation = step
        fresh = False


def _step(
    convolve: Convolution,
    pressure: FloatArray,
    separation: FloatArray,
    approach: float,
    load: float,
    search: _Search,
) -> tuple[FloatArray, FloatArray] | None:
    """One step; None if rounding leaves no direction of descent."""
    working = (pressure > 0) | (separation < approach)
    gradient = _mean_free(separation, working)
    direction = _conjugate(gradient, working, search)
    if search.length == 0:
        curvature = float(np.vdot(direction, convolve(direction)))
        if curvature <= 0:
            return None
        search.length = float(np.vdot(gradient, direction)) / curvature
    step, clipped = _projected_step(pressure, direction, search.length, load)
    slope = float(np.vdot(step, gradient))
    if slope >= 0:
        direction = gradient
        step, clipped = _projected_step(pressure, direction, search.length, load)
        slope = float(np.vdot(step, gradient))
        if slope >= 0:
            return None
    displaced = convolve(step)
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


def _mean_free(field: FloatArray, working: BoolArray) -> FloatArray:
    """The field less its mean on the working set, zero elsewhere."""
    return np.where(working, field - field[working].mean(), 0.0)


def _conjugate(gradient: FloatArray, working: BoolArray, search: _Search) -> FloatArray:
    """Polak-Ribiere direction on the working set; the gradient after a restart."""
    if search.direction is None or search.gradient is None:
        return gradient
    previous = search.gradient
    norm = float(np.vdot(previous, previous))
    factor = float(np.vdot(gradient, gradient - previous)) / norm if norm > 0 else 0.0
    if factor <= 0:
        return gradient
    direction = gradient + factor * _mean_free(search.direction, working)
    return direction if float(np.vdot(direction, gradient)) > 0 else gradient


def _projected_step(pressure: FloatArray, direction: FloatArray, length: float, load: float) -> tuple[FloatArray, bool]:
    """The step from the pressure to the projection of pressure - length * direction, and whether pixels were clipped.

    The projection onto {p >= 0, sum p = load} shifts the positive pixels by one constant until the sum is right.
    """
    trial = pressure - length * direction
    if trial.min() >= 0:
        return -length * direction, False
    shift, positive = 0.0, trial > 0
    while True:
        shift = (float(trial[positive].sum()) - load) / int(positive.sum())
        remaining = positive & (trial > shift)
        if remaining.sum() == positive.sum():
            return np.where(positive, trial - shift, 0.0) - pressure, True
        positive = remaining
