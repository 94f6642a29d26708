"""Ways to answer a contact problem, and which is the cheapest that is accurate enough.

What each way costs, and how wrong it is, was measured by ``asperity evaluate`` on the machine and with the weights that it
names, for maps of several sizes under several loads; between them it is interpolated.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np

from model.calibration import QUANTITIES, Calibration, ErrorBar
from model.errors import AccuracyError

Start = Literal["network", "coarse"]
Accuracy = Literal["fast", "balanced", "exact"] | float

TARGETS = {"fast": 0.03, "balanced": 0.01, "exact": 0.0}
"""Mean error that each word stands for: of 1 - Dice, and relative ones of contact area and resistance."""


@dataclass(frozen=True)
class Method:
    """A way to answer.

    Attributes:
        start: pressure predicted by the network, or prolonged from coarser grids by the solver itself.
        tolerance: to which the solver goes on from there; one for the network alone.
    """

    start: Start
    tolerance: float

    @property
    def name(self) -> str:
        """What the answer says of it."""
        if self.start == "coarse":
            return "solver"
        return "surrogate" if self == NETWORK else "surrogate and solver"


RARELY_BEYOND = 2.0
"""Multiple of the target that nine in ten errors must be within."""

LEAST_ERROR = 1e-9

NETWORK = Method("network", 1.0)
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
        method: which.
        pixels: of the maps.
        log_load: mean of log10 F / (E* A0 rms slope).
        milliseconds: median.
        errors: for each of ``calibration.QUANTITIES``.
    """

    method: Method
    pixels: int
    log_load: float
    milliseconds: float
    errors: dict[str, ErrorBar]


@dataclass(frozen=True)
class Ways:
    """What is known of the ways to answer.

    Attributes:
        measured: cost and error by size and load, to choose by.
        network: calibration of the error of a single answer of the network alone.
        stopped: the same of all methods whose solver stops early.
    """

    measured: tuple[Measured, ...]
    network: Calibration
    stopped: Calibration


@dataclass(frozen=True)
class Choice:
    """A method and what is expected of it."""

    method: Method
    milliseconds: float
    errors: dict[str, ErrorBar]


def target_of(accuracy: Accuracy) -> float:
    """The mean error that is allowed.

    Raises:
        AccuracyError: not a word of ``TARGETS`` and not a number from 0 to 1.
    """
    if isinstance(accuracy, str):
        if accuracy in TARGETS:
            return TARGETS[accuracy]
    elif 0 <= accuracy <= 1:
        return accuracy
    raise AccuracyError(
        f"The accuracy is {accuracy!r}; it must be {', '.join(TARGETS)}, or the mean error that is allowed, from 0 to 1."
    )


def choose(target: float, pixels: int, log_load: float, measured: Sequence[Measured]) -> list[Choice]:
    """The methods whose error is within a target, the cheapest first; the full solve always is.

    Args:
        target: mean error that is allowed.
        pixels: of the map.
        log_load: log10 F / (E* A0 rms slope).
        measured: what is known of the methods.
    """
    choices = [_expected(method, pixels, log_load, measured) for method in METHODS]
    good = [choice for choice in choices if choice.method == SOLVED or _within(choice.errors, target)]
    return sorted(good, key=lambda choice: choice.milliseconds)


def _within(errors: dict[str, ErrorBar], target: float) -> bool:
    """Whether all errors are within a target on average, and rarely far beyond it."""
    return all(error.expected <= target and error.bound <= RARELY_BEYOND * target for error in errors.values())


def _expected(method: Method, pixels: int, log_load: float, measured: Sequence[Measured]) -> Choice:
    """What was measured of a method at the nearest load of each size, interpolated between sizes on logarithmic scales."""
    sizes = sorted({one.pixels for one in measured})
    nearest = [
        min(
            (one for one in measured if (one.method, one.pixels) == (method, size)),
            key=lambda one: abs(one.log_load - log_load),
        )
        for size in sizes
    ]

    def at_size(values: list[float]) -> float:
        return float(np.exp(np.interp(np.log(pixels), np.log(sizes), np.log(np.maximum(values, LEAST_ERROR)))))

    errors = {}
    for quantity in QUANTITIES:
        bars = [one.errors[quantity] for one in nearest]
        errors[quantity] = ErrorBar(at_size([bar.expected for bar in bars]), at_size([bar.bound for bar in bars]))
    beyond = max(1.0, pixels / sizes[-1])
    return Choice(method, at_size([one.milliseconds for one in nearest]) * beyond, errors)


def stored(ways: Ways, sha256: str) -> str:
    """As JSON, a measurement a line, with the hash of the weights that were measured."""
    lines = ",\n".join(json.dumps(asdict(one)) for one in ways.measured)
    calibrations = f'"network": {json.dumps(ways.network)},\n"stopped": {json.dumps(ways.stopped)}'
    return f'{{"sha256": "{sha256}",\n"measured": [\n{lines}\n],\n{calibrations}}}\n'


def restored(text: str, sha256: str) -> Ways | None:
    """From JSON; None if other weights were measured."""
    content = json.loads(text)
    if content.get("sha256") != sha256:
        return None
    measured = tuple(
        Measured(
            Method(**one["method"]),
            one["pixels"],
            one["log_load"],
            one["milliseconds"],
            {quantity: ErrorBar(**bar) for quantity, bar in one["errors"].items()},
        )
        for one in content["measured"]
    )
    return Ways(measured, content["network"], content["stopped"])
