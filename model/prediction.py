"""What is predicted of a contact, and how wrong that is expected to be."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model.calibration import QUANTITIES, ErrorBar, Evidence
from solver.problem import BoolArray, FloatArray

EXACT = dict.fromkeys(QUANTITIES, ErrorBar(0.0, 0.0))
"""Error bars of the full solve."""

UNKNOWN = dict.fromkeys(QUANTITIES, ErrorBar(1.0, 1.0))
"""Error bars where nothing is known."""


@dataclass(frozen=True)
class ExpectedError:
    """Absolute errors of a prediction, dimensionless: as they are expected, and bounds that nine in ten stay below.

    Attributes:
        dice, dice_bound: 1 - Dice of the mask.
        contact_area, contact_area_bound: relative error of the contact area.
        contact_resistance, contact_resistance_bound: relative error of the contact resistance.
    """

    dice: float
    contact_area: float
    contact_resistance: float
    dice_bound: float
    contact_area_bound: float
    contact_resistance_bound: float

    @property
    def largest(self) -> float:
        """Of the errors as they are expected."""
        return max(self.dice, self.contact_area, self.contact_resistance)

    @classmethod
    def of(cls, bars: dict[str, ErrorBar]) -> "ExpectedError":
        """From the error bars of all quantities."""
        expected = {quantity: bar.expected for quantity, bar in bars.items()}
        return cls(**expected, **{f"{quantity}_bound": bar.bound for quantity, bar in bars.items()})


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the surrogate says of a problem.

    Attributes:
        contact_mask: where the bodies touch, shape (rows, columns).
        probability: of contact, float32, same shape.
        pressure: in Pa, same shape, zero off the mask; it carries the load exactly.
        method: ``surrogate``, ``surrogate and solver`` or ``solver``.
        evidence: what it tells of its own error.
        expected_error: zero where the solver answered to its usual tolerance.
        outside: why the problem lies outside what the network was trained on, where its expected error may be far too
            small; empty if it does not, or if the solver answered.
        timings_ms: by stage: ``features``, ``network``, ``check`` and ``solve``, as far as they were needed; those of
            a sweep are all in ``network``.
    """

    contact_mask: BoolArray
    probability: NDArray[np.float32]
    pressure: FloatArray
    method: str
    evidence: Evidence
    expected_error: ExpectedError
    outside: tuple[str, ...]
    timings_ms: dict[str, float]

    @property
    def in_distribution(self) -> bool:
        """Whether the problem lies within what the network was trained on, or the solver answered."""
        return not self.outside
