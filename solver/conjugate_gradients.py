"""Contact iteration: preconditioned projected conjugate gradients with one convolution a step.

The Polonsky-Keer iteration minimises 1/2 p.Kp + g0.p over the admissible pressures. Written as published it can
deadlock (one pixel in contact has no gradient left) and throws its direction away whenever a pixel joins. Here pixels that
overlap join the working set before the gradient is formed; the trial step is projected onto the admissible pressures; and
the exact line search runs along the projected step, so that the energy falls in every iteration and the only convolution
is that of the step. If the conjugate direction is not one of descent, the projected gradient, which always is, replaces it.

Dimensionless: see :mod:`solver.solve`. Fields hold one value a candidate pixel, shape (surfaces, count); the surfaces of a
batch step together, each with its own lengths, shape (surfaces,).

Source: Polonsky & Keer 1999, doi:10.1016/S0043-1648(99)00113-1.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.admissible import projected, within
from solver.arrays import Array, doubled, namespace
from solver.candidates import Candidates
from solver.certificate import certify

OnIteration = Callable[[int, float], None]

PATIENCE = 250
"""Iterations without a new lowest residual after which a descent ends."""

FIRST_LENGTH = 1.5
"""Length of the first step along the preconditioned gradient; the line search corrects it and what follows."""

EXACT_STEP = 0.6
"""Line-search lengths from here to 1 are taken as 1, which lands on exact zeros and still lowers the energy."""


@dataclass
class _Search:
    """What is carried from step to step; nothing but the length at the start.

    Attributes:
        length: of the next trial step, shape (surfaces,).
        direction: of the last step.
        gradient: there.
        preconditioned_norm: of the gradient, shape (surfaces,).
        working, weights: working set and row sums of the preconditioner on it.
    """

    length: Array
    direction: Array = None
    gradient: Array = None
    preconditioned_norm: Array = None
    working: Array = None
    weights: Array = None


def descend(
    candidates: Candidates,
    pressure: Array,
    separation: Array,
    load: Array,
    cap: Array | None,
    tolerance: float,
    iterations: range,
    on_iteration: OnIteration | None,
) -> tuple[Array, Array]:
    """Lower the contact energy over the pressures on the candidates, until half of the surfaces are done.

    Args:
        candidates: the pixels that may carry pressure, and their operators.
        pressure: an admissible start: p >= 0, summing to the load.
        separation: displacement + initial gap under that pressure, kept up by recurrence.
        load: what the pressures sum to, shape (surfaces,).
        cap: highest pressure, shape (surfaces,); None without a hardness.
        tolerance: for the residual on the candidates.
        iterations: numbers of the iterations that may be taken.
        on_iteration: called with (iteration, largest residual); what it raises ends the solve and propagates.

    Returns:
        For each surface the pressure of the lowest residual, by recurrence: within the tolerance if the surface is done,
        unless no step lowers it any more; and the number of iterations taken, shape (surfaces,).
    """
    xp = namespace(pressure)
    search = _Search(xp.full_like(load, FIRST_LENGTH))
    best, lowest = pressure, xp.full_like(load, np.inf)
    taken, lowest_at = xp.zeros_like(load), xp.zeros_like(load)
    running = lowest > 0
    iteration = iterations.start
    while True:
        certificate = certify(pressure, separation, load, cap)
        residual = certificate.residual
        better = running & (residual < lowest)
        best = xp.where(better[:, None], pressure, best)
        lowest, lowest_at = xp.where(better, residual, lowest), xp.where(better, taken, lowest_at)
        running = running & (residual > tolerance) & (taken - lowest_at < PATIENCE)
        if 2 * int(xp.count_nonzero(running)) <= running.shape[0] or iteration == iterations.stop:
            return best, taken
        step, length, displaced = _step(candidates, pressure, certificate.gap, load, cap, search)
        running = running & (length > 0)
        length = xp.where(running, length, 0.0)[:, None]
        pressure = within(pressure + length * step, cap)
        separation = separation + length * displaced
        taken = taken + doubled(running)
        if on_iteration is not None:
            on_iteration(iteration, float(xp.max(residual)))
        iteration += 1


def _step(
    candidates: Candidates, pressure: Array, gap: Array, load: Array, cap: Array | None, search: _Search
) -> tuple[Array, Array, Array]:
    """One step: where to, how far (zero if rounding leaves no direction of descent), and its displacement."""
    xp = namespace(pressure)
    movable = (pressure > 0) | (gap < 0)
    if cap is not None:
        movable = movable & ((pressure < cap[:, None]) | (gap > 0))
    working = doubled(movable)
    if search.working is None or not xp.all(working == search.working):
        search.working, search.weights = working, candidates.precondition(working, working)
    weights = search.weights
    gradient = (gap - (xp.vecdot(gap, working) / xp.sum(working, axis=1))[:, None]) * working
    descent = _load_free(candidates.precondition(gradient, working), weights)
    direction = _conjugate(descent, gradient, weights, working, search)
    step, clipped = _projected_step(pressure, direction, search.length, load, cap, weights)
    slope = xp.vecdot(step, gradient)
    rising = slope >= 0
    if xp.any(rising):
        plain, plain_clipped = _projected_step(pressure, gradient, search.length, load, cap, working)
        direction = xp.where(rising[:, None], gradient, direction)
        step, clipped = xp.where(rising[:, None], plain, step), xp.where(rising, plain_clipped, clipped)
        slope = xp.vecdot(step, gradient)
    displaced = candidates.convolve(step, load)
    curvature = xp.vecdot(step, displaced)
    downhill = (slope < 0) & (curvature > 0)
    optimum = xp.where(downhill, -slope, 0.0) / xp.where(downhill, curvature, 1.0)
    exact = clipped & (optimum >= EXACT_STEP)
    length = xp.where(exact, 1.0, optimum)
    if not xp.all(exact):
        falling = step < 0
        room = xp.min(xp.where(falling, pressure, np.inf) / xp.where(falling, -step, 1.0), axis=1)
        if cap is not None:
            rising_room = xp.where(step > 0, cap[:, None] - pressure, np.inf) / xp.where(step > 0, step, 1.0)
            room = xp.minimum(room, xp.min(rising_room, axis=1))
        length = xp.where(exact | (room > length), length, room)
    search.gradient = gradient
    search.direction = xp.where(clipped[:, None], -step / search.length[:, None], direction)
    search.length = search.length * xp.clip(optimum, 0.25, 4.0)
    return step, length, displaced


def _conjugate(descent: Array, gradient: Array, weights: Array, working: Array, search: _Search) -> Array:
    """Polak-Ribiere direction on the working set that leaves the load as it is, from the preconditioned gradient.

    What would change the load is taken out along the weights (the row sums of the preconditioner), which keeps the
    preconditioned gradient a direction of descent; a plain mean would not.
    """
    xp = namespace(descent)
    norm = search.preconditioned_norm
    search.preconditioned_norm = xp.vecdot(descent, gradient)
    if search.direction is None:
        return descent
    factor = xp.where(norm > 0, xp.vecdot(descent, gradient - search.gradient), 0.0) / xp.where(norm > 0, norm, 1.0)
    conjugate = descent + factor[:, None] * _load_free(search.direction * working, weights)
    descends = (factor > 0) & (xp.vecdot(conjugate, gradient) > 0)
    return xp.where(descends[:, None], conjugate, descent)


def _load_free(field: Array, weights: Array) -> Array:
    """The field less that multiple of the weights which makes it sum to zero."""
    xp = namespace(field)
    return field - (xp.sum(field, axis=1) / xp.sum(weights, axis=1))[:, None] * weights


def _projected_step(
    pressure: Array, direction: Array, length: Array, load: Array, cap: Array | None, weights: Array
) -> tuple[Array, Array]:
    """The step from the pressure to an admissible one near pressure - length * direction, and whether it was clipped."""
    xp = namespace(pressure)
    free = -length[:, None] * direction
    trial = pressure + free
    clipped = xp.min(trial, axis=1) < 0
    if cap is not None:
        clipped = clipped | (xp.max(trial, axis=1) > cap)
    if not xp.any(clipped):
        return free, clipped
    return projected(trial, load, cap, weights) - pressure, clipped
