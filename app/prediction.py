"""From a problem to the numbers of its contact: predict, measure."""

from dataclasses import asdict, dataclass
from time import perf_counter

from app.reading import Reading
from app.schemas import ExpectedError, Numbers
from model import Surrogate
from model.methods import Accuracy
from solver import ContactProblem, boyer_resistance
from solver.problem import BoolArray

OUT_OF_DISTRIBUTION = (
    "The problem lies outside what the surrogate was trained on, so the expected error may be too small; verify it, or ask "
    "for the accuracy 'exact'. The reason: {reasons}."
)


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
    """A problem and what the surrogate says of it."""

    problem: ContactProblem
    mask: BoolArray
    numbers: Numbers


def predict(
    reading: Reading, resistivity: float | None, accuracy: Accuracy, surrogate: Surrogate, stopwatch: Stopwatch
) -> Predicted:
    """Predict the contact of a problem that was read.

    Args:
        reading: of the uploaded height map.
        resistivity: mean of the two bodies, in ohm m; None if no resistance is asked for.
        accuracy: asked for.
        surrogate: the network, loaded.
        stopwatch: gets the stages of the surrogate, and measure.

    Raises:
        NotConvergedError: the solver was needed and did not converge.
    """
    problem, warnings = reading.problem, list(reading.warnings)
    prediction = surrogate.predict(problem, accuracy)
    stopwatch.laps(prediction.timings_ms)

    mask = prediction.contact_mask
    resistance = None
    if resistivity is not None:
        resistance = boyer_resistance(mask, problem.pixel_size, resistivity)
    if not prediction.in_distribution:
        warnings.append(OUT_OF_DISTRIBUTION.format(reasons="; ".join(prediction.outside)))
    stopwatch.lap("measure")

    numbers = Numbers(
        method=prediction.method,
        model=surrogate.version,
        contact_area_mm2=float(mask.sum()) * problem.pixel_area * 1e6,
        contact_fraction=float(mask.mean()),
        contact_resistance_ohm=resistance,
        expected_error=ExpectedError(**asdict(prediction.expected_error)),
        in_distribution=prediction.in_distribution,
        surface=reading.surface,
        warnings=warnings,
        timings_ms=stopwatch.timings_ms,
    )
    return Predicted(problem, mask, numbers)
