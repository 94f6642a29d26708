"""From a problem to the numbers of its contact: predict, measure."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from time import perf_counter

from app.reading import Reading
from app.requests import Output
from app.schemas import ExpectedError, Numbers
from model import Surrogate
from model.methods import Accuracy
from model.prediction import Prediction
from solver import boyer_resistance
from worker.statistics import resistances, roughness_parameters, solution_of, statistics

OUT_OF_DISTRIBUTION = (
    "The problem lies outside what the surrogate was trained on, so the expected error may be too small; verify it, or ask "
    "for the accuracy 'exact'. The reason: {reasons}."
)

BEYOND_ELASTICITY = 0.5
"""Mean contact pressure over E* at which strains are no longer small."""

TOO_MUCH_LOAD = (
    "The mean contact pressure is {ratio:.2g} times the effective modulus, far beyond what linear elasticity describes; "
    "check load, units and modulus, or give a hardness."
)


@dataclass(frozen=True)
class Wanted:
    """What is wanted of a prediction.

    Attributes:
        accuracy: see ``model.methods.target_of``.
        resistivity: mean of the two bodies, in ohm m; None if no resistance is asked for.
        outputs: what else.
    """

    accuracy: Accuracy = "balanced"
    resistivity: float | None = None
    outputs: Sequence[Output] = ()


class Stopwatch:
    """Wall time by stage."""

    def __init__(self) -> None:
        self._stages_ms: dict[str, float] = {}
        self._started = self._last = perf_counter()

    def lap(self, stage: str) -> None:
        """End a stage."""
        self.laps({stage: (perf_counter() - self._last) * 1e3})

    def laps(self, stages_ms: dict[str, float]) -> None:
        """End several stages that were timed elsewhere."""
        self._stages_ms |= stages_ms
        self._last = perf_counter()

    @property
    def timings_ms(self) -> dict[str, float]:
        """Milliseconds by stage, and their total."""
        return self._stages_ms | {"total": (self._last - self._started) * 1e3}


@dataclass(frozen=True, eq=False)
class Predicted:
    """What the surrogate says of a problem, and the numbers that were asked for."""

    prediction: Prediction
    numbers: Numbers


def predict(
    reading: Reading, wanted: Wanted, surrogate: Surrogate, stopwatch: Stopwatch, estimate: Prediction | None = None
) -> Predicted:
    """Predict the contact of a problem that was read.

    Args:
        reading: of the uploaded height map.
        wanted: of the prediction.
        surrogate: the network, loaded.
        stopwatch: gets the stages of the surrogate, and measure.
        estimate: what the network says, if that is known already.

    Raises:
        NotConvergedError: the solver was needed and did not converge.
        InvalidHeightsError: the roughness of a map that has none was asked for.
    """
    problem, warnings = reading.problem, list(reading.warnings)
    prediction = surrogate.predict(problem, wanted.accuracy, estimate)
    stopwatch.laps(prediction.timings_ms)

    mask, resistivity = prediction.contact_mask, wanted.resistivity
    solution = solution_of(problem, prediction.pressure) if {"statistics", "resistances"} & set(wanted.outputs) else None
    if not prediction.in_distribution:
        warnings.append(OUT_OF_DISTRIBUTION.format(reasons="; ".join(prediction.outside)))
    ratio = problem.nominal_pressure / mask.mean() / problem.effective_modulus
    if ratio > BEYOND_ELASTICITY:
        warnings.append(TOO_MUCH_LOAD.format(ratio=ratio))
    measured = {
        "contact_resistance_ohm": resistivity and boyer_resistance(mask, problem.pixel_size, resistivity),
        "statistics": statistics(problem, solution) if solution and "statistics" in wanted.outputs else None,
        "resistances": resistances(problem, solution, resistivity)
        if solution and resistivity and "resistances" in wanted.outputs
        else None,
        "roughness": roughness_parameters(problem) if "roughness" in wanted.outputs else None,
    }
    stopwatch.lap("measure")
    numbers = Numbers(
        **measured,  # type: ignore[arg-type]
        method=prediction.method,
        model=surrogate.version,
        contact_area_mm2=float(mask.sum()) * problem.pixel_area * 1e6,
        contact_fraction=float(mask.mean()),
        expected_error=ExpectedError(**asdict(prediction.expected_error)),
        in_distribution=prediction.in_distribution,
        surface=reading.surface,
        warnings=warnings,
        timings_ms=stopwatch.timings_ms,
    )
    return Predicted(prediction, numbers)
