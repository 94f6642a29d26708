"""The KKT certificate: how far a pressure is from satisfying the contact conditions (paper Eqs. 1-6).

Dimensionless: pressures sum to ``load``; gaps are in units of the height scale of the problem.
"""

from dataclasses import dataclass

import numpy as np

from solver.problem import FloatArray


@dataclass(frozen=True)
class Certificate:
    """Violation of each contact condition, dimensionless.

    Attributes:
        approach: delta for which the gap is measured: the pressure-weighted mean of displacement + initial gap.
        complementarity: sum p |g| / sum p; zero when every loaded pixel touches.
        penetration: deepest overlap, max(-g, 0), over all pixels.
        load_balance: |sum p / load - 1|.
    """

    approach: float
    complementarity: float
    penetration: float
    load_balance: float

    @property
    def residual(self) -> float:
        """The largest violation."""
        return max(self.complementarity, self.penetration, self.load_balance)


def certify(pressure: FloatArray, separation: FloatArray, load: float) -> Certificate:
    """Check the contact conditions.

    Args:
        pressure: non-negative, shape (rows, columns).
        separation: displacement + initial gap (the gap but for the approach), same shape.
        load: what the pressure must sum to.
    """
    total = float(pressure.sum())
    approach = float(np.vdot(pressure, separation)) / total
    gap = separation - approach
    return Certificate(
        approach=approach,
        complementarity=float(np.vdot(pressure, np.abs(gap))) / total,
        penetration=max(0.0, -float(gap.min())),
        load_balance=abs(total / load - 1),
    )
