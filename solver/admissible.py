"""The admissible pressures: nowhere negative, nowhere above the hardness, and summing to the load.

Arrays have the shape (surfaces, pixels); loads and the highest pressures, ``cap``, (surfaces,), None without a hardness.
"""

from solver.arrays import Array, doubled, namespace

SNAP = 1e-12
"""Pressures this close to the highest one, relatively, are set to it."""

MOST_TRIALS = 100


def within(pressure: Array, cap: Array | None) -> Array:
    """The pressure with what is negative, or above the highest, cut off."""
    xp = namespace(pressure)
    cut = xp.where(pressure > 0, pressure, 0.0)
    if cap is None:
        return cut
    highest = cap[:, None]
    return xp.where(cut < highest * (1 - SNAP), cut, highest)


def balanced(pressure: Array, load: Array, cap: Array | None) -> Array:
    """The pressure scaled to the load; what is at the highest stays there."""
    xp = namespace(pressure)
    if cap is None:
        return pressure * (load / xp.sum(pressure, axis=1))[:, None]
    flowing = doubled(pressure >= cap[:, None])
    carried = xp.vecdot(pressure, flowing)
    elastic = xp.sum(pressure, axis=1) - carried
    factor = (load - carried) / xp.where(elastic > 0, elastic, 1.0)
    return pressure * xp.where(flowing > 0, 1.0, factor[:, None])


def projected(trial: Array, load: Array, cap: Array | None, weights: Array) -> Array:
    """An admissible pressure near a trial one that sums to the load but breaks the bounds.

    It is cut off at the bounds, and what lies between them is shifted along the weights until the sum is the load; with
    equal weights this is the nearest admissible pressure.

    Args:
        trial: pressures.
        load: what they must sum to.
        cap: highest pressure.
        weights: how much of the shift each pixel takes, not negative.
    """
    return _projected(trial, load, weights) if cap is None else _projected_below(trial, load, cap, weights)


def _projected(trial: Array, load: Array, weights: Array) -> Array:
    """Without a highest pressure, dropping the negative ones until none is left takes a few steps."""
    xp = namespace(trial)
    shifted, positive = trial, xp.count_nonzero(trial > 0, axis=1)
    while True:
        kept = doubled(shifted > 0)
        share = xp.vecdot(weights, kept)
        shift = (xp.vecdot(trial, kept) - load) / xp.where(share > 0, share, 1.0)
        shifted = (trial - shift[:, None] * weights) * kept
        remaining = xp.count_nonzero(shifted > 0, axis=1)
        if xp.all(remaining == positive):
            break
        positive = remaining
    if xp.any(positive == 0):  # rounding: the load is too small beside what the pixels lose
        highest = xp.arange(trial.shape[1])[None, :] == xp.argmax(trial, axis=1)[:, None]
        shifted = xp.where((positive == 0)[:, None], doubled(highest) * load[:, None], shifted)
    return shifted


def _projected_below(trial: Array, load: Array, cap: Array, weights: Array) -> Array:
    """Newton's method for the shift, kept between bounds on it: the sum falls with the shift, piecewise linearly."""
    xp = namespace(trial)
    highest = cap[:, None]
    movable = weights > 0
    safe = xp.where(movable, weights, 1.0)
    high = xp.max(xp.where(movable, trial / safe, -xp.inf), axis=1)
    low = xp.min(xp.where(movable, (trial - highest) / safe, xp.inf), axis=1)
    shift = xp.zeros_like(load)
    for _ in range(MOST_TRIALS):
        shifted = trial - shift[:, None] * weights
        inside = doubled((shifted > 0) & (shifted < highest))
        shifted = within(shifted, cap)
        excess = xp.sum(shifted, axis=1) - load
        if xp.all(xp.abs(excess) <= SNAP * load):
            break
        low, high = xp.where(excess > 0, shift, low), xp.where(excess < 0, shift, high)
        slope = xp.vecdot(weights, inside)
        shift = shift + xp.where(slope > 0, excess, 0.0) / xp.where(slope > 0, slope, 1.0)
        shift = xp.where((slope > 0) & (shift > low) & (shift < high), shift, (low + high) / 2)
    return shifted
