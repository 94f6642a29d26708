"""The KKT certificate: how far a pressure is from satisfying the contact conditions (paper Eqs. 1-6).

Dimensionless: pressures sum to ``load``; gaps are in units of the height scale of the problem.
"""

from dataclasses import dataclass

from solver.arrays import Array, namespace


@dataclass(frozen=True, eq=False)
class Certificate:
    """Violation of each contact condition, dimensionless; but for the gap one value a surface, shape (surfaces,).

    Attributes:
        gap: displacement + initial gap - approach, shape (surfaces, pixels).
        approach: delta for which the gap is measured: the mean of displacement + initial gap, weighted with the pressures
            below the highest.
        complementarity: sum p |g| / sum p; zero when every loaded pixel touches.
        penetration: deepest overlap, max(-g), over all pixels that do not flow; negative where nothing overlaps.
        load_balance: |sum p / load - 1|.
        residual: the largest violation.
    """

    gap: Array
    approach: Array
    complementarity: Array
    penetration: Array
    load_balance: Array
    residual: Array


def certify(pressure: Array, separation: Array, load: Array, cap: Array | None = None) -> Certificate:
    """Check the contact conditions.

    Args:
        pressure: non-negative, shape (surfaces, pixels).
        separation: displacement + initial gap (the gap but for the approach), same shape.
        load: what the pressures of each surface must sum to, shape (surfaces,).
        cap: highest pressure, shape (surfaces,); where it is reached the bodies may overlap.
    """
    xp = namespace(pressure)
    total = xp.sum(pressure, axis=1)
    if cap is None:
        approach = xp.vecdot(pressure, separation) / total
        gap = separation - approach[:, None]
        broken = gap
    else:
        flowing = pressure >= cap[:, None]
        elastic = xp.where(flowing, 0.0, pressure)
        carried = xp.sum(elastic, axis=1)
        mean = xp.vecdot(elastic, separation) / xp.where(carried > 0, carried, 1.0)
        approach = xp.where(carried > 0, mean, xp.max(xp.where(flowing, separation, -xp.inf), axis=1))
        gap = separation - approach[:, None]
        broken = xp.where(flowing & (gap < 0), 0.0, gap)
    complementarity = xp.vecdot(pressure, xp.abs(broken)) / total
    penetration = -xp.min(broken, axis=1)
    load_balance = xp.abs(total / load - 1)
    residual = xp.maximum(xp.maximum(complementarity, penetration), load_balance)
    return Certificate(gap, approach, complementarity, penetration, load_balance, residual)
