"""Ways to answer a contact problem, and which is the cheapest that is accurate enough.

What each way costs, and how wrong it is, was measured by ``asperity evaluate`` on the machine and with the weights that it
names, for maps of several sizes under several loads; between them it is interpolated.
"""

import json
import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Literal

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


Table = Mapping[Method, Mapping[int, Sequence[Measured]]]
"""Measurements by method and pixels."""


def tabulated(measured: Iterable[Measured]) -> Table:
    """Measurements of several loads in their places."""
    table: dict[Method, dict[int, list[Measured]]] = {}
    for one in measured:
        table.setdefault(one.method, {}).setdefault(one.pixels, []).append(one)
    return table


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

    @cached_property
    def table(self) -> Table:
        """The measurements in their places."""
        return tabulated(self.measured)


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


def choose(target: float, pixels: int, log_load: float, table: Table) -> list[Choice]:
    """The methods whose error is within a target, the cheapest first; the full solve always is.

    Args:
        target: mean error that is allowed.
        pixels: of the map.
        log_load: log10 F / (E* A0 rms slope).
        table: what is known of the methods.
    """
    choices = [_expected(method, pixels, log_load, by_pixels) for method, by_pixels in table.items()]
    good = [choice for choice in choices if choice.method == SOLVED or _within(choice.errors, target)]
    return sorted(good, key=lambda choice: choice.milliseconds)


def _within(errors: dict[str, ErrorBar], target: float) -> bool:
    """Whether all errors are within a target on average, and rarely far beyond it."""
    return all(error.expected <= target and error.bound <= RARELY_BEYOND * target for error in errors.values())


def _expected(method: Method, pixels: int, log_load: float, by_pixels: Mapping[int, Sequence[Measured]]) -> Choice:
    """What was measured of a method at the nearest load, interpolated between sizes on logarithmic scales."""
    sizes = sorted(by_pixels)
    place = bisect_left(sizes, pixels)
    ends = sizes[max(place - 1, 0)], sizes[min(place, len(sizes) - 1)]
    share = math.log(pixels / ends[0]) / math.log(ends[1] / ends[0]) if ends[0] < ends[1] else 0.0
    below, above = (min(by_pixels[end], key=lambda one: abs(one.log_load - log_load)) for end in ends)

    def between(low: float, high: float) -> float:
        return float(max(low, LEAST_ERROR) ** (1 - share) * max(high, LEAST_ERROR) ** share)

    errors = {}
    for quantity in QUANTITIES:
        low, high = below.errors[quantity], above.errors[quantity]
        errors[quantity] = ErrorBar(between(low.expected, high.expected), between(low.bound, high.bound))
    beyond = max(1.0, pixels / sizes[-1])
    return Choice(method, between(below.milliseconds, above.milliseconds) * beyond, errors)


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
