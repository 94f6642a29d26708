"""Contact iteration: preconditioned projected conjugate gradients with one convolution a step.

The Polonsky-Keer iteration minimises 1/2 p.Kp + g0.p over the pressures p >= 0 of given sum. Written as published it can
deadlock (one pixel in contact has no gradient left) and throws its direction away whenever a pixel joins. Here pixels that
overlap join the working set before the gradient is formed; the trial step is projected onto the admissible pressures; and
the exact line search runs along the projected step, so that the energy falls in every iteration and the only convolution
is that of the step. If the conjugate direction is not one of descent, the projected gradient, which always is, replaces it.

Dimensionless: see :mod:`solver.solve`. Vectors hold one value a candidate pixel.

Source: Polonsky & Keer 1999, doi:10.1016/S0043-1648(99)00113-1.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.candidates import Candidates
from solver.certificate import certify
from solver.problem import FloatArray

OnIteration = Callable[[int, float], None]

PATIENCE = 250
"""Iterations without a new lowest residual after which a descent ends."""

FIRST_LENGTH = 1.5
"""Length of the first step along the preconditioned gradient; the line search corrects it and what follows."""

EXACT_STEP = 0.6
"""Line-search lengths from here to 1 are taken as 1, which lands on exact zeros and still lowers the energy."""


@dataclass
class _Search:
    """What the conjugate direction carries from step to step; no direction at the start."""

    direction: FloatArray | None = None
    gradient: FloatArray | None = None
    preconditioned_norm: float = 0.0
    length: float = FIRST_LENGTH


def descend(
    candidates: Candidates,
    pressure: FloatArray,
    separation: FloatArray,
    load: float,
    tolerance: float,
    iterations: range,
    on_iteration: OnIteration | None,
) -> tuple[FloatArray, int]:
    """Lower the contact energy over the pressures on the candidates.

    Args:
        candidates: the pixels that may carry pressure, and their operators.
        pressure: an admissible start: p >= 0, summing to the load.
        separation: displacement + initial gap under that pressure, kept up by recurrence.
        load: what the pressures sum to.
        tolerance: for the residual on the candidates.
        iterations: numbers of the iterations that may be taken.
        on_iteration: called with (iteration, residual); what it raises ends the solve and propagates.

    Returns:
        The pressure where the residual, by recurrence, is within the tolerance, or no step lowers it any more; and the
        number of the last iteration.
    """
    search = _Search()
    lowest, lowest_at = np.inf, iterations.start
    for iteration in iterations:
        certificate = certify(pressure, separation, load)
        residual = certificate.residual
        if residual < lowest:
            lowest, lowest_at = residual, iteration
        if residual <= tolerance or iteration - lowest_at >= PATIENCE:
            return pressure, iteration - 1
        step = _step(candidates, pressure, separation, certificate.approach, load, search)
        if step is None:
            return pressure, iteration - 1
        pressure, separation = step
        if on_iteration is not None:
            on_iteration(iteration, residual)
    return pressure, iterations.stop - 1


def _step(
    candidates: Candidates,
    pressure: FloatArray,
    separation: FloatArray,
    approach: float,
    load: float,
    search: _Search,
) -> tuple[FloatArray, FloatArray] | None:
    """One step; None if rounding leaves no direction of descent."""
    working = ((pressure > 0) | (separation < approach)).astype(np.float64)
    gradient = (separation - float(np.vdot(separation, working)) / float(working.sum())) * working
    preconditioned = candidates.precondition(np.column_stack([gradient, working]), working)
    weights = np.ascontiguousarray(preconditioned[:, 1])
    descent = _load_free(preconditioned[:, 0], weights)
    direction = _conjugate(descent, gradient, weights, working, search)
    step, clipped = _projected_step(pressure, direction, search.length, load, weights)
    slope = float(np.vdot(step, gradient))
    if slope >= 0:
        direction = gradient
        step, clipped = _projected_step(pressure, direction, search.length, load, working)
        slope = float(np.vdot(step, gradient))
        if slope >= 0:
            return None
    displaced = candidates.convolve(step)
    curvature = float(np.vdot(step, displaced))
    if curvature <= 0:
        return None
    optimum = -slope / curvature
    if clipped and optimum >= EXACT_STEP:
        taken = 1.0
    else:
        falling = step < 0
        taken = min(optimum, float(np.min(pressure[falling] / -step[falling], initial=np.inf)))
    search.gradient = gradient
    search.direction = -step / search.length if clipped else direction
    search.length *= min(max(optimum, 0.25), 4.0)
    return np.maximum(pressure + taken * step, 0.0), separation + taken * displaced


def _conjugate(
    descent: FloatArray, gradient: FloatArray, weights: FloatArray, working: FloatArray, search: _Search
) -> FloatArray:
    """Polak-Ribiere direction on the working set that leaves the load as it is, from the preconditioned gradient.

    What would change the load is taken out along the weights (the row sums of the preconditioner), which keeps the
    preconditioned gradient a direction of descent; a plain mean would not.
    """
    direction = descent
    if search.direction is not None and search.gradient is not None and search.preconditioned_norm > 0:
        factor = float(np.vdot(descent, gradient - search.gradient)) / search.preconditioned_norm
        conjugate = descent + factor * _load_free(search.direction * working, weights)
        if factor > 0 and np.vdot(conjugate, gradient) > 0:
            direction = conjugate
    search.preconditioned_norm = float(np.vdot(descent, gradient))
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
    shifted, positive = trial, np.count_nonzero(trial > 0)
    while True:
        kept = (shifted > 0).astype(np.float64)
        if not kept.any():  # rounding: the load is too small beside what the pixels lose
            return np.where(np.arange(trial.size) == trial.argmax(), load, 0.0) - pressure, True
        shift = (float(np.vdot(trial, kept)) - load) / float(np.vdot(weights, kept))
        shifted = (trial - shift * weights) * kept
        remaining = np.count_nonzero(shifted > 0)
        if remaining == positive:
            return shifted - pressure, True
        positive = remaining
