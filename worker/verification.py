"""The one kind of job: a reference solve of a predicted problem, and the comparison of the two."""

import time
from dataclasses import asdict, dataclass
from typing import Any

from rq import get_current_job
from rq.job import Job

from model.metrics import compare
from solver import ContactProblem, Solution, Status, boyer_resistance, solve
from solver.problem import BoolArray
from worker.errors import JobNotFoundError
from worker.masks import mask_png
from worker.parcel import JobKeys, Parcel

REPORT_EVERY_S = 0.2


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
        return None
    if finished := job.return_value():
        return dict(finished)
    parcel = keys.receive_parcel()
    try:
        result, reference_mask = solve_and_compare(parcel, _Reporter(job, keys))
    except CanceledError:
        keys.drop_parcel()
        return None
    job.connection.set(keys.reference_mask, mask_png(reference_mask), ex=job.result_ttl)
    keys.expire_parcel()
    return result


class _Reporter:
    """Puts the progress into the job, and stops the solve on request; now and then, so that Redis costs no time."""

    def __init__(self, job: Job, keys: JobKeys) -> None:
        self.job = job
        self.keys = keys
        self.reported_at = 0.0

    def __call__(self, iteration: int, residual: float) -> None:
        now = time.monotonic()
        if now - self.reported_at < REPORT_EVERY_S:
            return
        self.reported_at = now
        if self.keys.cancel_requested():
            raise CanceledError
        self.job.meta["progress"] = {"iteration": iteration, "residual": residual}
        self.job.save_meta()


def _reference(problem: ContactProblem, on_iteration: _Reporter) -> Solution:
    """The solution by the multilevel sum, which shares nothing with the transforms that the prediction may rest on.

    Transforms take over where it cannot be used: on periodic surfaces, and where its error is too large beside the gap.
    """
    if problem.boundary == "periodic":
        return solve(problem, on_iteration=on_iteration)
    solution = solve(problem, "multilevel", on_iteration=on_iteration)
    if solution.converged:
        return solution
    return solve(problem, initial_pressure=solution.pressure, on_iteration=on_iteration)


def solve_and_compare(parcel: Parcel, on_iteration: _Reporter) -> tuple[dict[str, Any], BoolArray]:
    """Solve the problem of a parcel and compare the reference mask with the predicted one."""
    problem, predicted, resistivity = parcel.problem, parcel.predicted_mask, parcel.resistivity
    started = time.perf_counter()
    solution = _reference(problem, on_iteration)
    seconds = time.perf_counter() - started
    mask = solution.contact_mask

    resistance, resistance_error = None, None
    if resistivity is not None:
        resistance = boyer_resistance(mask, problem.pixel_size, resistivity)
        resistance_error = boyer_resistance(predicted, problem.pixel_size, resistivity) / resistance - 1
    reference = Reference(
        contact_area_mm2=float(mask.sum()) * problem.pixel_area * 1e6,
        contact_fraction=solution.contact_fraction,
        contact_resistance_ohm=resistance,
        status=solution.status.value,
        converged=solution.status is Status.CONVERGED,
        residual=solution.residual,
        iterations=solution.iterations,
        solve_seconds=seconds,
    )
    comparison = asdict(compare(mask, predicted)) | {"resistance_error": resistance_error}
    return {"reference": asdict(reference), "comparison": comparison}, mask
