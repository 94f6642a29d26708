"""The surrogate: from a contact problem to its predicted contact mask, with an estimate of its own error."""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from model.features import SMALLEST_SIDE, features, network_input
from model.mask import decide, doubt
from model.network import balanced_pressure
from model.weights import SHIPPED, Weights, load_weights
from solver.errors import NotConvergedError
from solver.problem import BoolArray, ContactProblem, FloatArray
from solver.solve import solve


@dataclass(frozen=True)
class ExpectedError:
    """Expected absolute errors of a prediction, dimensionless.

    Attributes:
        dice: expected 1 - Dice of the mask.
        contact_area: relative error of the contact area.
        contact_resistance: relative error of the contact resistance.
    """

    dice: float
    contact_area: float
    contact_resistance: float


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the surrogate says of a problem.

    Attributes:
        contact_mask: where the bodies touch, shape (rows, columns).
        probability: of contact, float32, same shape.
        pressure: in Pa, same shape, zero off the mask; it carries the load exactly.
        method: ``surrogate``, or ``fft`` where the map is too small or too flat for it and the solver answered.
        expected_error: zero where the solver answered.
        in_distribution: whether load and aspect of the pixels lie within what was trained; nothing else is looked at, and
            outside the expected error may be far too small.
        timings_ms: by stage: ``features`` and ``network``, or ``solve``.
    """

    contact_mask: BoolArray
    probability: NDArray[np.float32]
    pressure: FloatArray
    method: str
    expected_error: ExpectedError
    in_distribution: bool
    timings_ms: dict[str, float]


class Surrogate:
    """A network with its weights, ready to predict."""

    def __init__(self, weights: Weights) -> None:
        self.weights = weights
        self.precision = torch.bfloat16 if torch.cpu.get_capabilities().get("avx512_bf16") else torch.float32
        self._network = weights.network.to(self.precision, memory_format=torch.channels_last)  # type: ignore[call-overload]

    @classmethod
    def load(cls, directory: Path = SHIPPED) -> "Surrogate":
        """Load weights by hash; the shipped ones unless a directory is given.

        Raises:
            WeightsError: a file is missing or its hash differs.
        """
        return cls(load_weights(directory))

    @property
    def version(self) -> str:
        """Name and start of the hash of the weights."""
        return self.weights.version

    def predict(self, problem: ContactProblem) -> Prediction:
        """Predict where the bodies touch.

        Maps under ``SMALLEST_SIDE`` pixels a side, flat ones and those with a hardness, of which the network knows nothing,
        are solved instead.
        """
        if min(problem.shape) < SMALLEST_SIDE or problem.rms_height == 0 or problem.hardness is not None:
            return _solved(problem)
        started = perf_counter()
        given = features([problem])
        fields = network_input(given)
        between = perf_counter()
        with torch.inference_mode():
            logits, relative = self._network(fields.to(self.precision), given.conditions.to(self.precision))
            probability = torch.sigmoid(logits)[0].numpy()
            mask = decide(probability)
            pressure = np.where(mask, balanced_pressure(logits, relative, given.load)[0].numpy(), 0.0)
        finished = perf_counter()
        return Prediction(
            contact_mask=mask,
            probability=probability,
            pressure=pressure * (problem.nominal_pressure / pressure.mean()),
            method="surrogate",
            expected_error=self._expected_error(doubt(probability, mask)),
            in_distribution=self._in_distribution(given.conditions[0]),
            timings_ms={"features": (between - started) * 1e3, "network": (finished - between) * 1e3},
        )

    def _expected_error(self, doubted: float) -> ExpectedError:
        """Expected errors are proportional to the doubt; training measured the factors on its held-out surfaces."""
        factors = self.weights.manifest["calibration"]
        return ExpectedError(
            dice=min(factors["dice"] * doubted, 1.0),
            contact_area=factors["contact_area"] * doubted,
            contact_resistance=factors["contact_resistance"] * doubted,
        )

    def _in_distribution(self, conditions: Tensor) -> bool:
        trained = self.weights.manifest["conditions"]
        lowest, highest = torch.tensor(trained["lowest"]), torch.tensor(trained["highest"])
        return bool(((lowest <= conditions) & (conditions <= highest)).all())


def _solved(problem: ContactProblem) -> Prediction:
    started = perf_counter()
    solution = solve(problem)
    if not solution.converged:
        raise NotConvergedError(f"{solution.status.value} The residual is {solution.residual:.1e}.")
    return Prediction(
        contact_mask=solution.contact_mask,
        probability=solution.contact_mask.astype(np.float32),
        pressure=solution.pressure,
        method="fft",
        expected_error=ExpectedError(0.0, 0.0, 0.0),
        in_distribution=True,
        timings_ms={"solve": (perf_counter() - started) * 1e3},
    )
