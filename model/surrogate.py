"""The surrogate: from a contact problem to where the bodies touch, with an estimate of its own error.

The network answers where it is the cheapest way that is accurate enough; elsewhere the solver does, from the network's
pressure or its own start, as far as the accuracy asks for.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from model.calibration import Evidence, error_bars
from model.contact import Contact
from model.domain import outside, statistics
from model.engine import Engine
from model.features import SMALLEST_SIDE, Features, features, log_load, network_input
from model.mask import active, doubt
from model.methods import NETWORK, SOLVED, Accuracy, Method, choose, target_of
from model.metrics import dice
from model.prediction import EXACT, UNKNOWN, ExpectedError, Prediction
from model.tiles import tiles
from model.weights import SHIPPED, Weights, load_weights
from solver.errors import InvalidLoadError
from solver.problem import Boundary, ContactProblem
from solver.solve import solve

BATCH_PIXELS = 2**18
"""Pixels that the network sees at a time."""

WRAPPED = 16
"""Pixels of the opposite edge that the network sees around a periodic map."""

NODES = 1.25
"""Ratio of the loads of a sweep at which the network is asked."""


class Surrogate:
    """A network with its weights, ready to predict."""

    def __init__(self, weights: Weights) -> None:
        self.weights = weights
        self._engine = Engine(weights.network)

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

    def predict(
        self, problem: ContactProblem, accuracy: Accuracy = "balanced", estimate: Prediction | None = None
    ) -> Prediction:
        """Predict where the bodies touch, in the cheapest way that is as accurate as asked for.

        What each way costs, and how wrong it usually is, was measured; the error bar of the answer itself has the last word,
        and the solver goes on from there until it is within what is asked for.

        Maps under ``SMALLEST_SIDE`` pixels a side, flat ones and those with a hardness, of which the network knows nothing,
        are solved.

        Args:
            problem: what touches.
            accuracy: ``fast``, ``balanced``, ``exact``, or the mean error that is allowed of 1 - Dice, contact area and
                contact resistance alike.
            estimate: what the network alone says, if that is known already (:meth:`estimate_batch`).

        Raises:
            AccuracyError: another accuracy.
            NotConvergedError: the solver was needed and did not converge.
        """
        target = target_of(accuracy)
        return self._completed(problem, self._plan(problem, target), target, estimate)

    def begins_with_network(self, problem: ContactProblem, accuracy: Accuracy) -> bool:
        """Whether :meth:`predict` asks the network first.

        Raises:
            AccuracyError: another accuracy.
        """
        return self._plan(problem, target_of(accuracy))[0].start == "network"

    def predict_sweep(
        self, problem: ContactProblem, loads: Sequence[float], accuracy: Accuracy = "balanced"
    ) -> Iterator[Prediction]:
        """Predict for one surface under many loads, as :func:`predict` would for each.

        Where the network comes first, it is asked for all loads at once (:func:`estimate_sweep`).

        Args:
            problem: surface and material; its own load does not matter.
            loads: in N, in any order.
            accuracy: as for :func:`predict`.

        Yields:
            One a load, in the order of the loads, as soon as it is there.

        Raises:
            AccuracyError: another accuracy.
            InvalidLoadError: a load that is not positive and finite.
            NotConvergedError: the solver was needed and did not converge.
        """
        target = target_of(accuracy)
        problems = [replace(problem, load=load) for load in loads]
        plans = [self._plan(one, target) for one in problems]
        asked = [load for load, plan in zip(loads, plans, strict=True) if plan[0].start == "network"]
        estimates = iter(self.estimate_sweep(problem, asked) if asked else [])
        for one, plan in zip(problems, plans, strict=True):
            yield self._completed(one, plan, target, next(estimates) if plan[0].start == "network" else None)

    def _plan(self, problem: ContactProblem, target: float) -> list[Method]:
        """Ways to answer that are usually accurate enough, the cheapest first."""
        if min(problem.shape) < SMALLEST_SIDE or problem.rms_slope == 0 or problem.hardness is not None:
            return [SOLVED]
        if self.weights.ways is None:
            return [NETWORK]
        choices = choose(target, problem.heights.size, log_load(problem), self.weights.ways.table)
        return [choice.method for choice in choices]

    def _completed(
        self, problem: ContactProblem, plan: list[Method], target: float, estimate: Prediction | None = None
    ) -> Prediction:
        """The first way of a plan, and the solver from there until the error bar of the answer is within the target."""
        method = NETWORK if plan[0].start == "network" else plan[0]
        prediction = estimate if estimate and method == NETWORK else self.answer(problem, method)
        for tolerance in [further.tolerance for further in plan]:
            if prediction.in_distribution and prediction.expected_error.largest <= target:
                break
            if tolerance < method.tolerance:
                method = Method(method.start, tolerance)
                prediction = self._solved(problem, method, prediction)
        return prediction

    def answer(self, problem: ContactProblem, method: Method) -> Prediction:
        """What one way to answer says."""
        if method == NETWORK:
            return self.estimate(problem)
        return self._solved(problem, method, self.estimate(problem) if method.start == "network" else None)

    def estimate(self, problem: ContactProblem) -> Prediction:
        """What the network alone says."""
        return self.estimate_batch([problem])[0]

    def estimate_batch(self, problems: Sequence[ContactProblem]) -> list[Prediction]:
        """What the network alone says of problems of one shape, pixel size and boundary."""
        started = perf_counter()
        given = features(problems)
        between = perf_counter()
        logits, relative = self._evaluate(given, problems[0].boundary)
        finished = perf_counter()
        contacts = [Contact.of(*one) for one in zip(problems, logits, relative, strict=True)]
        disagreements = [contact.disagreement() for contact in contacts]
        checked = perf_counter()
        timings_ms = {
            "features": (between - started) * 1e3,
            "network": (finished - between) * 1e3,
            "check": (checked - finished) * 1e3,
        }
        shared = {stage: milliseconds / len(problems) for stage, milliseconds in timings_ms.items()}
        every = zip(contacts, disagreements, statistics(given), strict=True)
        return [self._prediction(contact, disagreement, found, shared) for contact, disagreement, found in every]

    def estimate_sweep(self, problem: ContactProblem, loads: Sequence[float]) -> list[Prediction]:
        """What the network alone says of one surface under many loads.

        What it says changes smoothly with the load, so it is asked at loads a factor of ``NODES`` apart and interpolated
        between them, linearly in the logarithm of the load.

        Args:
            problem: surface and material; its own load does not matter.
            loads: in N, at least one, in any order.

        Returns:
            One a load, in the order of the loads.

        Raises:
            InvalidLoadError: no load, or one that is not positive and finite.
        """
        if len(loads) == 0:
            raise InvalidLoadError("There is no load to predict for; give one or more.")
        problems = [replace(problem, load=load) for load in loads]
        logs = np.log(loads)
        count = min(len(set(loads)), 1 + int(np.ceil(np.ptp(logs) / np.log(NODES))))
        nodes = np.linspace(logs.min(), logs.max(), count) if count < len(set(loads)) else np.unique(logs)
        started = perf_counter()
        at_nodes = [replace(problem, load=float(np.exp(node))) for node in nodes]
        given = features(at_nodes)
        logits, relative = self._evaluate(given, problem.boundary)
        contacts = (Contact.of(*one) for one in zip(at_nodes, logits, relative, strict=True))
        disagreements = torch.tensor([contact.disagreement() for contact in contacts])
        fields = (logits, relative, disagreements, statistics(given))
        predictions = []
        for one, log in zip(problems, logs, strict=True):
            above = int(np.clip(np.searchsorted(nodes, log), 1, max(len(nodes) - 1, 1)))
            below, above = above - 1, min(above, len(nodes) - 1)
            share = float((log - nodes[below]) / (nodes[above] - nodes[below])) if above > below else 0.0
            between = [torch.lerp(field[below], field[above], share) for field in fields]
            contact = Contact.of(one, between[0], between[1])
            timings_ms = {"network": (perf_counter() - started) * 1e3 / len(loads)}
            predictions.append(self._prediction(contact, float(between[2]), between[3], timings_ms))
        return predictions

    def _prediction(self, contact: Contact, disagreement: float, found: Tensor, timings_ms: dict[str, float]) -> Prediction:
        """A prediction from what the network says, and the statistics of the problem."""
        own = doubt(contact.probability, contact.mask)
        evidence = Evidence(own + disagreement, int(np.count_nonzero(contact.mask)))
        return Prediction(
            contact_mask=contact.mask,
            probability=contact.probability,
            pressure=contact.pressure,
            method=NETWORK.name,
            evidence=evidence,
            expected_error=self._expected_error(evidence, NETWORK),
            outside=outside(found, self.weights.manifest["domain"]),
            timings_ms=timings_ms,
        )

    def _solved(self, problem: ContactProblem, method: Method, reached: Prediction | None = None) -> Prediction:
        """What the solver says, from its own start or from what has been reached so far."""
        started = perf_counter()
        start = None if reached is None else reached.pressure
        solution = solve(problem, tolerance=method.tolerance, initial_pressure=start).checked()
        exact = method.tolerance == SOLVED.tolerance
        before = {} if reached is None else reached.timings_ms
        mask = solution.contact_mask if exact else active(problem, solution.pressure, solution.gap)
        pressure = np.where(mask, np.maximum(solution.pressure, np.finfo(np.float32).tiny), 0.0)
        disagreement = 1 - dice(solution.contact_mask, mask)
        evidence = Evidence(disagreement, int(np.count_nonzero(mask)))
        return Prediction(
            contact_mask=mask,
            probability=mask.astype(np.float32),
            pressure=pressure * (problem.nominal_pressure / pressure.mean()),
            method=method.name,
            evidence=evidence,
            expected_error=self._expected_error(evidence, method),
            outside=(),
            timings_ms=before | {"solve": before.get("solve", 0.0) + (perf_counter() - started) * 1e3},
        )

    def _expected_error(self, evidence: Evidence, method: Method) -> ExpectedError:
        """As it was measured; unknown where it was not."""
        ways = self.weights.ways
        if method.tolerance == SOLVED.tolerance:
            return ExpectedError.of(EXACT)
        if ways is None:
            return ExpectedError.of(UNKNOWN)
        return ExpectedError.of(error_bars(evidence, ways.network if method == NETWORK else ways.stopped))

    @torch.inference_mode()
    def _evaluate(self, given: Features, boundary: Boundary) -> tuple[Tensor, Tensor]:
        """Logits and relative pressures, a few maps or one tile at a time, to stay small in memory."""
        rows, columns = given.heights.shape[1:]
        most = max(1, BATCH_PIXELS // (rows * columns))
        around = WRAPPED if boundary == "periodic" else 0
        parts = []
        for part in given.split(most):
            fields = functional.pad(network_input(part), (around,) * 4, mode="circular" if around else "constant")
            parts.append(self._in_tiles(fields, part.conditions)[..., around : around + rows, around : around + columns])
        logits, relative = (torch.cat(parts) if len(parts) > 1 else parts[0]).unbind(1)
        return logits, relative

    def _in_tiles(self, fields: Tensor, conditions: Tensor) -> Tensor:
        windows = list(tiles(fields.shape[2], fields.shape[3]))
        if len(windows) == 1:
            return self._engine(fields, conditions)
        said = torch.empty((len(fields), 2, *fields.shape[2:]))
        for seen, kept in windows:
            inside = [slice(k.start - s.start, k.stop - s.start) for s, k in zip(seen, kept, strict=True)]
            said[:, :, *kept] = self._engine(fields[:, :, *seen], conditions)[:, :, *inside]
        return said
