"""From a start to a certified solution: descents on candidates in single precision between checks of all pixels in double.

Dimensionless: see :mod:`solver.solve`. Fields have the shape (surfaces, rows, columns); what belongs to a surface has the
shape (surfaces,).
"""

from dataclasses import dataclass

import numpy as np

from solver.admissible import balanced, projected
from solver.arrays import Array, moved, namespace, on_processor
from solver.candidates import Candidates
from solver.certificate import certify
from solver.coarsening import block_means, prolonged
from solver.conjugate_gradients import OnIteration, descend
from solver.full_contact import full_contact_filter
from solver.operators import Operators
from solver.solution import Status

COLD_START_SIDE = 64
"""Pixels a side up to which the pressure starts uniform; larger maps start from the solution of one twice as coarse."""

COARSE_TOLERANCE = 1e-2
COARSE_ITERATIONS = 200

CANDIDATE_GAP = 0.03
"""Pixels with gaps below this, in rms heights, may come into contact; a check of all pixels adds what was missed."""

INNER_SHARE = 0.5
"""Share of the tolerance to which the pressures on the candidates are brought before all pixels are checked."""

FULL_CONTACT = 0.9
"""Share of pixels under pressure from which all are candidates, with the preconditioner of full contact."""

FAR = 1e100
"""Gap where there is no pixel."""


@dataclass(eq=False)
class Refined:
    """How one surface ended: its best pressure and what a fresh convolution says of it.

    Attributes:
        pressure: shape (rows, columns).
        separation: displacement + initial gap, same shape.
        approach: delta.
        residual: of the certificate, and what the error of the operator, which moves surfaces by the approach, may add.
        iterations: number taken.
        status: whether the residual is within the tolerance.
    """

    pressure: Array
    separation: Array
    approach: float
    residual: float
    iterations: int = 0
    status: Status = Status.CONVERGED


def refine(
    operators: Operators,
    initial_gap: Array,
    load: Array,
    cap: Array | None,
    pressure: Array,
    tolerance: float,
    max_iterations: int,
    on_iteration: OnIteration | None,
) -> list[Refined]:
    """Bring pressures within the tolerance, or say why not.

    Where rounding in single precision is in the way, descents on all pixels in double precision follow.

    Args:
        operators: displacement by pressure.
        initial_gap: gap before deformation.
        load: what the pressures of each surface sum to.
        cap: highest pressure; None without a hardness.
        pressure: an admissible start.
        tolerance: for the residual.
        max_iterations: for each surface.
        on_iteration: called with (iteration, largest residual); what it raises ends the solve and propagates.
    """
    results = _passes(operators, initial_gap, load, cap, pressure, tolerance, range(max_iterations), on_iteration, False)
    for i, rough in enumerate(results):
        if rough.status is Status.STAGNATED:
            one = slice(i, i + 1)
            left = range(rough.iterations, max_iterations)
            results[i] = _passes(
                operators,
                initial_gap[one],
                load[one],
                None if cap is None else cap[one],
                rough.pressure[None],
                tolerance,
                left,
                on_iteration,
                True,
            )[0]
    return results


def _passes(
    operators: Operators,
    initial_gap: Array,
    load: Array,
    cap: Array | None,
    pressure: Array,
    tolerance: float,
    allowed: range,
    on_iteration: OnIteration | None,
    precise: bool,
) -> list[Refined]:
    """Descend on the candidates, check all pixels, and so on until it holds.

    Surfaces for which a pass neither adds candidates nor halves the residual have stagnated. If ``precise``, all pixels are
    candidates, and nothing is in single precision.
    """
    xp = namespace(pressure)
    exact = operators.exact()
    best: dict[int, Refined] = {}
    surfaces = np.arange(pressure.shape[0])
    mask = np.full(pressure.shape, precise)
    lowest = np.full(surfaces.size, np.inf)
    iterations = np.full(surfaces.size, allowed.start)
    while True:
        separation = exact(pressure) + initial_gap
        flat = (surfaces.size, -1)
        certificate = certify(xp.reshape(pressure, flat), xp.reshape(separation, flat), load, cap)
        approach = on_processor(certificate.approach)
        residual = on_processor(certificate.residual) + operators.error * np.abs(approach)
        lost = ~np.isfinite(residual)  # beyond what numbers can hold: no pass brings it back
        first = [surface not in best for surface in surfaces]
        for i in np.flatnonzero((residual < lowest) | first):
            best[surfaces[i]] = Refined(pressure[i], separation[i], float(approach[i]), float(residual[i]))
        near = (pressure > 0) | (separation - certificate.approach[:, None, None] < CANDIDATE_GAP)
        grown = mask | on_processor(near)
        converged, spent = residual <= tolerance, iterations >= allowed.stop
        stalled = (residual > lowest / 2) & (grown == mask).all(axis=(1, 2))
        ended = converged | spent | stalled | lost
        for i in np.flatnonzero(ended):
            result = best[surfaces[i]]
            result.iterations = int(iterations[i])
            if not converged[i]:
                result.status = Status.ITERATION_LIMIT if spent[i] else Status.STAGNATED
        if ended.all():
            return [best[surface] for surface in sorted(best)]
        if ended.any():
            going = np.flatnonzero(~ended)
            surfaces, grown, lowest, residual, iterations = (
                array[going] for array in (surfaces, grown, lowest, residual, iterations)
            )
            kept = moved(going, operators.device)
            pressure, separation, initial_gap, load = (a[kept] for a in (pressure, separation, initial_gap, load))
            cap = None if cap is None else cap[kept]
        full = operators.device is None and bool(((pressure > 0).mean(axis=(1, 2)) > FULL_CONTACT).all())
        mask, lowest = grown | full, np.minimum(lowest, residual)

        candidates = Candidates(
            mask,
            operators.pixel_size,
            operators.exact() if precise else operators.inner(mask),
            full_contact_filter(operators.boundary, operators.shape, operators.pixel_size) if full else None,
        )
        before = int(iterations.max())
        values, taken = descend(
            candidates,
            candidates.gather(pressure, 0.0),
            candidates.gather(separation, FAR),
            load,
            cap,
            INNER_SHARE * tolerance,
            range(before + 1, allowed.stop + 1),
            on_iteration,
        )
        pressure = candidates.scatter(balanced(values, load, cap))
        iterations = iterations + on_processor(taken).astype(np.int64)


def cascade(
    operators: Operators, initial_gap: Array, load: Array, cap: Array | None, on_iteration: OnIteration | None
) -> Array:
    """A start: the pressure on pixels twice as large, loosely solved; uniform where the map is small.

    How the coarse solve ends does not matter: any pressure is a start. Its iterations count as number 0.
    """
    xp = namespace(initial_gap)
    rows, columns = operators.shape
    if max(rows, columns) <= COLD_START_SIDE or min(rows, columns) < COLD_START_SIDE // 2:
        return xp.ones_like(initial_gap) * (load / (rows * columns))[:, None, None]
    coarser, coarse_gap, coarse_cap = operators.coarser(), block_means(initial_gap, 2), None if cap is None else 2 * cap
    start = cascade(coarser, coarse_gap, load / 2, coarse_cap, on_iteration)
    report = None if on_iteration is None else lambda _, residual: on_iteration(0, residual)
    coarse = refine(coarser, coarse_gap, load / 2, coarse_cap, start, COARSE_TOLERANCE, COARSE_ITERATIONS, report)
    return admissible(prolonged(xp.stack([one.pressure for one in coarse]), 2, operators.shape), load, cap)


def admissible(pressure: Array, load: Array, cap: Array | None) -> Array:
    """Pressures of any sum, shape (surfaces, rows, columns), scaled to the loads, and below the highest."""
    xp = namespace(pressure)
    flat = balanced(xp.reshape(pressure, (pressure.shape[0], -1)), load, None)
    if cap is not None:
        flat = projected(flat, load, cap, xp.ones_like(flat))
    return xp.reshape(flat, pressure.shape)
