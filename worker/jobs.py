"""The queue of verifications, as the service sees it."""

from dataclasses import dataclass
from typing import Any, Literal

from redis import Redis
from rq import Queue, Retry
from rq.exceptions import InvalidJobOperation, NoSuchJobError
from rq.job import Job, JobStatus
from rq.serializers import JSONSerializer

from solver.problem import BoolArray, ContactProblem
from worker.errors import JobNotFoundError, QueueFullError
from worker.parcel import JobKeys, Parcel
from worker.settings import Settings
from worker.store import new_id

QUEUE = "asperity"
RETRIES = 3
"""How often a job is taken up again after its worker was lost, before it counts as failed."""

JobStatusName = Literal["queued", "started", "finished", "failed", "canceled"]

_STATUS: dict[JobStatus, JobStatusName] = {
    JobStatus.CREATED: "queued",
    JobStatus.QUEUED: "queued",
    JobStatus.SCHEDULED: "queued",
    JobStatus.DEFERRED: "queued",
    JobStatus.STARTED: "started",
    JobStatus.FINISHED: "finished",
    JobStatus.FAILED: "failed",
    JobStatus.STOPPED: "canceled",
    JobStatus.CANCELED: "canceled",
}


@dataclass(frozen=True)
class JobState:
    """Where a job stands.

    Attributes:
        progress: ``iteration`` and ``residual`` of the solve; None before its first report.
        reference: the reference solution (worker.verification.Reference as a dict) of a finished job.
        comparison: agreement of the prediction with the reference, of a finished job.
        error: why a failed job failed.
    """

    id: str
    status: JobStatusName
    progress: dict[str, Any] | None
    reference: dict[str, Any] | None
    comparison: dict[str, Any] | None
    error: str | None


class VerificationQueue:
    """Verifications in Redis. Jobs are JSON, never pickles."""

    def __init__(self, connection: Redis, settings: Settings) -> None:
        self.connection = connection
        self.settings = settings
        self.queue = Queue(QUEUE, connection=connection, serializer=JSONSerializer, default_timeout=settings.job_timeout_s)

    def enqueue(self, problem: ContactProblem, predicted_mask: BoolArray, resistivity: float | None) -> str:
        """Queue the verification of a prediction; returns the job's id.

        Raises:
            QueueFullError: as many jobs as may wait are waiting.
        """
        if self.queue.count >= self.settings.queue_length:
            raise QueueFullError(
                f"{self.settings.queue_length} verifications are waiting; try again later, or send verify=false."
            )
        job_id, keep_s = new_id(), self.settings.retention_s
        JobKeys(self.connection, job_id).send_parcel(Parcel(problem, predicted_mask, resistivity), keep_s)
        self.queue.enqueue_call(
            "worker.verification.verify",
            job_id=job_id,
            description=f"verify {problem.shape[0]} x {problem.shape[1]}",
            retry=Retry(max=RETRIES),
            result_ttl=keep_s,
            failure_ttl=keep_s,
        )
        return job_id

    def state(self, job_id: str) -> JobState:
        """Where a job stands.

        Raises:
            JobNotFoundError: there is none of that id.
        """
        job = self._fetch(job_id)
        status = _STATUS[job.get_status()]
        result = job.return_value() if status == "finished" else None
        if result is None and (status == "finished" or JobKeys(self.connection, job_id).cancel_requested()):
            status = "canceled"
        return JobState(
            id=job_id,
            status=status,
            progress=job.meta.get("progress"),
            reference=result["reference"] if result else None,
            comparison=result["comparison"] if result else None,
            error=_reason(job) if status == "failed" else None,
        )

    def cancel(self, job_id: str) -> JobState:
        """Cancel a job, queued or running; one that has ended stays as it is.

        A running solve stops at its next report; if its worker is lost, whoever takes the job up finds the request.

        Raises:
            JobNotFoundError: there is none of that id.
        """
        state = self.state(job_id)
        if state.status in ("queued", "started"):
            keys = JobKeys(self.connection, job_id)
            keys.request_cancel(self.settings.retention_s)
            if state.status == "queued":
                self._remove_from_queue(job_id)
                keys.drop_parcel()
        return self.state(job_id)

    def reference_mask(self, job_id: str) -> bytes:
        """The reference mask of a finished job as a 1-bit PNG file.

        Raises:
            JobNotFoundError: there is no such job, or it has not finished.
        """
        data = self.connection.get(JobKeys(self.connection, job_id).reference_mask)
        if not isinstance(data, bytes):
            status = self.state(job_id).status
            raise JobNotFoundError(f"Job {job_id} is {status}; it has a reference mask once it has finished.")
        return data

    def _fetch(self, job_id: str) -> Job:
        try:
            return Job.fetch(job_id, connection=self.connection, serializer=JSONSerializer)
        except (NoSuchJobError, ValueError) as error:
            days = self.settings.retention_days
            raise JobNotFoundError(f"There is no job {job_id!r}, or it is gone: jobs are kept for {days:g} days.") from error

    def _remove_from_queue(self, job_id: str) -> None:
        job = self._fetch(job_id)
        try:
            job.cancel()
        except InvalidJobOperation:
            return
        job.save()


def _reason(job: Job) -> str:
    """The last line of what RQ recorded: the error and its message."""
    result = job.latest_result()
    text = result.exc_string if result and result.exc_string else "The job failed without a word."
    return text.strip().splitlines()[-1]
