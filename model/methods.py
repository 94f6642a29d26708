"""Ways to answer a contact problem, and which is the cheapest that is accurate enough.

What each way costs, and how wrong it is, was measured by ``asperity evaluate`` on the machine and with the weights that it
names, for maps of several sizes under several loads; between them it is interpolated.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from model.errors import AccuracyError

Start = Literal["network", "coarse"]
Accuracy = Literal["fast", "balanced", "exact"] | float

TARGETS = {"fast": 0.03, "balanced": 0.01, "exact": 0.0}
"""Mean of 1 - Dice that each word stands for."""


@dataclass(frozen=True)
class Method:
    """A way to answer.

    Attributes:
        start: pressure predicted by the network, or prolonged from coarser grids by the solver itself.
        tolerance: to which the solver goes on from there; None for the network alone.
    """

    start: Start
    tolerance: float | None

    @property
    def name(self) -> str:
        """What the answer says of it."""
        if self.start == "coarse":
            return "solver"
        return "surrogate" if self.tolerance is None else "surrogate and solver"


NETWORK = Method("network", None)
SOLVED = Method("coarse", 1e-6)
METHODS = (
    NETWORK,
    Method("network", 1e-1),
    Method("network", 1e-2),
    Method("network", 1e-3),
    Method("coarse", 1e-1),
    Method("coarse", 1e-2),
    Method("coarse", 1e-3),
    SOLVED,
)


@dataclass(frozen=True)
class Measured:
    """A method on problems of one size and load.

    Attributes:
        start, tolerance: of the method.
        pixels: of the maps.
        log_load: mean of log10 F / (E* A0 rms slope).
        milliseconds: median.
        dice_error, area_error, resistance_error: means of 1 - Dice and of the relative errors.
    """

    start: Start
    tolerance: float | None
    pixels: int
    log_load: float
    milliseconds: float
    dice_error: float
    area_error: float
    resistance_error: float


@dataclass(frozen=True)
class Choice:
    """A method and what is expected of it."""

    method: Method
    milliseconds: float
    dice_error: float
    area_error: float
    resistance_error: float


def choose(accuracy: Accuracy, pixels: int, log_load: float, measured: Sequence[Measured]) -> Choice:
    """The cheapest method whose expected error is within the accuracy.

    Args:
        accuracy: a word of ``TARGETS``, or the mean of 1 - Dice that is allowed.
        pixels: of the map.
        log_load: log10 F / (E* A0 rms slope).
        measured: what is known of the methods.

    Raises:
        AccuracyError: not a word of ``TARGETS`` and not a number from 0 to 1.
    """
    target = _target(accuracy)
    choices = [choice for method in METHODS if (choice := _expected(method, pixels, log_load, measured))]
    good = [choice for choice in choices if choice.method == SOLVED or choice.dice_error <= target]
    return min(good, key=lambda choice: choice.milliseconds)


def _target(accuracy: Accuracy) -> float:
    if isinstance(accuracy, str):
        if accuracy in TARGETS:
            return TARGETS[accuracy]
    elif 0 <= accuracy <= 1:
        return accuracy
    raise AccuracyError(f"The accuracy is {accuracy!r}; it must be {', '.join(TARGETS)}, or 1 - Dice as a number from 0 to 1.")


def _expected(method: Method, pixels: int, log_load: float, measured: Sequence[Measured]) -> Choice | None:
    """What was measured of a method at the nearest loads, interpolated between sizes; None if nothing was."""
    mine = [one for one in measured if (one.start, one.tolerance) == (method.start, method.tolerance)]
    if not mine:
        return None
    sizes = sorted({one.pixels for one in mine})
    nearest = [min((o for o in mine if o.pixels == size), key=lambda o: abs(o.log_load - log_load)) for size in sizes]

    def between(values: list[float]) -> float:
        logs = np.log(np.maximum(values, 1e-9))
        place = np.log(pixels)
        inside = float(np.exp(np.interp(place, np.log(sizes), logs)))
        return inside

    milliseconds = between([one.milliseconds for one in nearest])
    if pixels > sizes[-1]:
        milliseconds *= pixels / sizes[-1]
    return Choice(
        method,
        milliseconds,
        between([one.dice_error for one in nearest]),
        between([one.area_error for one in nearest]),
        between([one.resistance_error for one in nearest]),
    )
