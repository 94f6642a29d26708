"""The one kind of job: a reference solve, and its comparison with the prediction if one was made."""

import math
import time
from dataclasses import asdict, dataclass
from typing import Any

from rq import get_current_job
from rq.job import Job

from model.metrics import compare
from solver import ContactProblem, Solution, Status, boyer_resistance, solve
from solver.conjugate_gradients import OnIteration
from solver.problem import FloatArray
from worker.arrays import npy
from worker.ending import end
from worker.errors import JobNotFoundError
from worker.masks import mask_png
from worker.parcel import FieldName, JobKeys, Parcel
from worker.statistics import resistances, statistics

REPORT_EVERY_S = 0.1

TOLERANCE = 1e-6
"""Residual at which the reference solve ends."""


class CanceledError(Exception):
    """Raised within a solve that is to stop."""


@dataclass(frozen=True)
class Reference:
    """The reference solution without its arrays.

    ``status`` is the solver's message for people; ``converged`` says whether the residual is within the tolerance, and
    where it is not, neither these numbers nor the comparison prove anything.
    """

    contact_area_mm2: float
    contact_fraction: float
    contact_resistance_ohm: float | None
    status: str
    converged: bool
    residual: float
    iterations: int
    solve_seconds: float
    statistics: dict[str, Any] | None
    resistances: dict[str, Any] | None


def verify() -> dict[str, Any] | None:
    """Run the current job; one that has run before, because its worker seemed lost, keeps its result.

    Returns:
        ``reference`` (see :class:`Reference`) and ``comparison``; None if the job was canceled.
    """
    job = get_current_job()
    if job is None:
        raise JobNotFoundError("A verification runs in a worker, as a job.")
    keys = JobKeys(job.connection, job.id)
    if keys.cancel_requested():
        _canceled(job, keys)
        return None
    if finished := job.return_value():
        return dict(finished)
    parcel = keys.receive_parcel()
    try:
        result, solution = solve_and_compare(parcel, _Reporter(job, keys))
    except CanceledError:
        _canceled(job, keys)
        return None
    job.connection.set(keys.reference_mask, mask_png(solution.contact_mask), ex=job.result_ttl)
    fields: dict[FieldName, FloatArray] = {"pressure": solution.pressure, "gap": solution.gap}
    for name, values in fields.items():
        if name in parcel.outputs:
            job.connection.set(keys.fields[name], npy(values), ex=job.result_ttl)
    proven = result["comparison"] if solution.converged else None
    end(job, "finished", (parcel.model, proven["dice"]) if proven else None)
    keys.expire_parcel()
    return result


def _canceled(job: Job, keys: JobKeys) -> None:
    keys.drop_parcel()
    end(job, "canceled")


class _Reporter:
    """Puts the progress into the job, and stops the solve on request; now and then, so that Redis costs no time."""

    def __init__(self, job: Job, keys: JobKeys) -> None:
        self.job = job
        self.keys = keys
        self.reported_at = 0.0
        self.first: tuple[float, float] | None = None

    def __call__(self, iteration: int, residual: float) -> None:
        now = time.monotonic()
        if now - self.reported_at < REPORT_EVERY_S:
            return
        self.reported_at = now
        if self.keys.cancel_requested():
            raise CanceledError
        left = self._seconds_left(now, iteration, residual)
        self.job.meta["progress"] = {"iteration": iteration, "residual": residual, "seconds_left": left}
        self.job.save_meta()

    def _seconds_left(self, now: float, iteration: int, residual: float) -> float | None:
        """If the residual goes on to fall by as many decades a second as since the first report on the full grid."""
        if iteration == 0 or residual <= TOLERANCE:
            return None
        if self.first is None:
            self.first = now, residual
            return None
        then, highest = self.first
        decades = math.log(highest / residual)
        return (now - then) * math.log(residual / TOLERANCE) / decades if decades > 0 else None


def _reference(problem: ContactProblem, on_iteration: OnIteration) -> Solution:
    """The solution by the multilevel sum, which shares nothing with the transforms that the prediction may rest on.

    Transforms take over where it cannot be used: on periodic surfaces, and where its error is too large beside the gap.
    """
    if problem.boundary == "periodic":
        return solve(problem, tolerance=TOLERANCE, on_iteration=on_iteration)
    solution = solve(problem, "multilevel", TOLERANCE, on_iteration=on_iteration)
    if solution.converged:
        return solution
    return solve(problem, "fft", TOLERANCE, solution.pressure, on_iteration)


def solve_and_compare(parcel: Parcel, on_iteration: OnIteration) -> tuple[dict[str, Any], Solution]:
    """Solve the problem of a parcel, and compare the reference mask with the predicted one if there is one.

    Returns:
        ``reference`` (see :class:`Reference`) and ``comparison``, which is None without a prediction; and the solution.
    """
    problem, predicted, resistivity = parcel.problem, parcel.predicted_mask, parcel.resistivity
    started = time.perf_counter()
    solution = _reference(problem, on_iteration)
    seconds = time.perf_counter() - started
    mask = solution.contact_mask

    wanted = {
        "statistics": lambda: statistics(problem, solution).model_dump(),
        "resistances": lambda: resistances(problem, solution, resistivity).model_dump() if resistivity else None,
    }
    reference = Reference(
        contact_area_mm2=float(mask.sum()) * problem.pixel_area * 1e6,
        contact_fraction=solution.contact_fraction,
        contact_resistance_ohm=resistivity and boyer_resistance(mask, problem.pixel_size, resistivity),
        status=solution.status.value,
        converged=solution.status is Status.CONVERGED,
        residual=solution.residual,
        iterations=solution.iterations,
        solve_seconds=seconds,
        **{name: measure() if name in parcel.outputs else None for name, measure in wanted.items()},
    )
    comparison = None
    if predicted is not None:
        resistance_error = None
        if resistivity:
            ratio = [boyer_resistance(one, problem.pixel_size, resistivity) for one in (predicted, mask)]
            resistance_error = ratio[0] / ratio[1] - 1
        comparison = asdict(compare(mask, predicted)) | {"resistance_error": resistance_error}
    return {"reference": asdict(reference), "comparison": comparison}, solution
