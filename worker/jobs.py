"""The queue of reference solves, as the service sees it."""

import time
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Literal, cast

from redis import Redis
from rq import Worker
from rq.exceptions import NoSuchJobError
from rq.job import Job, JobStatus

from worker.connection import redis_failures
from worker.ending import end, fail_for_good
from worker.errors import JobNotFoundError, JobTooLargeError, QueueFullError, WebhookError
from worker.job_queue import JobQueue
from worker.parcel import FieldName, JobKeys, Parcel
from worker.settings import Settings
from worker.store import is_id, new_id
from worker.tracing import carrier
from worker.webhooks import public_address

JobStatusName = Literal["queued", "started", "finished", "failed", "canceled"]

JobKind = Literal["verification", "solve"]

INDEX = "asperity:jobs"
"""Sorted set of the ids of all jobs that are kept, by the time they came."""

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
        kind: whether it checks a prediction.
        queue_position: jobs that are before it; None once it has started.
        progress: ``iteration``, ``residual`` and ``seconds_left`` of the solve; None before its first report
            and after its end.
        reference: the reference solution (worker.verification.Reference as a dict) of a finished job.
        comparison: agreement of the prediction with the reference, of a finished verification.
        error: why a failed job failed.
        created_at, started_at, ended_at: as far as that has happened.
    """

    id: str
    kind: JobKind
    status: JobStatusName
    queue_position: int | None
    progress: dict[str, Any] | None
    reference: dict[str, Any] | None
    comparison: dict[str, Any] | None
    error: str | None
    created_at: datetime | None
    started_at: datetime | None
    ended_at: datetime | None


class VerificationQueue:
    """Reference solves in Redis. Jobs are JSON, never pickles."""

    def __init__(self, connection: Redis, settings: Settings) -> None:
        self.connection = connection
        self.settings = settings
        self.queue = JobQueue(connection, settings.job_timeout_s)

    @redis_failures()
    def enqueue(
        self,
        parcel: Parcel,
        job_id: str | None = None,
        request_id: str | None = None,
        webhook_url: str | None = None,
    ) -> str:
        """Queue a reference solve, which verifies the prediction that is in the parcel if one is; returns the job's id.

        Args:
            parcel: what to solve.
            job_id: see ``worker.store.new_id``; a new one if left out.
            request_id: of the request that asked for it, for the worker's log.
            webhook_url: told when the job has ended.

        Raises:
            WebhookError: the webhook cannot be used.
            JobTooLargeError: the solve would take more memory than a worker has.
            QueueFullError: as many jobs as may wait are waiting, or their problems fill the memory of the Redis.
            QueueUnavailableError: Redis fails.
        """
        if webhook_url is not None:
            self.check_webhook(webhook_url)
        self._refuse_if_too_large(parcel.problem.shape)
        self._refuse_if_full()
        job_id, keep_s = job_id or new_id(), self.settings.retention_s
        JobKeys(self.connection, job_id).send_parcel(parcel, keep_s)
        rows, columns = parcel.problem.shape
        kind: JobKind = "solve" if parcel.predicted_mask is None else "verification"
        self.queue.submit(
            "worker.verification.verify",
            job_id,
            f"{kind} {rows} x {columns}",
            keep_s,
            meta={"kind": kind, "request_id": request_id, "webhook_url": webhook_url, "trace": carrier()},
        )
        self.connection.zadd(INDEX, {job_id: time.time()})
        self.connection.zremrangebyscore(INDEX, 0, time.time() - keep_s)
        return job_id

    @redis_failures()
    def newest(self, count: int, before: str | None) -> list[JobState]:
        """Jobs from the newest to the oldest, of all kinds and ends.

        Args:
            count: at most.
            before: id of a job, older ones than which are wanted; None to begin with the newest.

        Raises:
            JobNotFoundError: there is no such job to begin from.
            QueueUnavailableError: Redis fails.
        """
        first = 0
        if before is not None:
            rank = self.connection.zrevrank(INDEX, before)
            if rank is None:
                raise JobNotFoundError(f"There is no job {before} to go on from; begin again without it.")
            first = cast(int, rank) + 1
        names = cast(list[bytes], self.connection.zrevrange(INDEX, first, first + count - 1))
        found = []
        for name in names:
            with suppress(JobNotFoundError):  # it has just expired
                found.append(self.state(name.decode()))
        return found

    @redis_failures()
    def waiting(self) -> int:
        """Number of jobs that wait.

        Raises:
            QueueUnavailableError: Redis fails.
        """
        return int(self.queue.count)

    @redis_failures()
    def workers(self) -> int:
        """Number of workers whose heartbeat is heard.

        Raises:
            QueueUnavailableError: Redis fails.
        """
        return Worker.count(queue=self.queue)

    @redis_failures()
    def state(self, job_id: str) -> JobState:
        """Where a job stands; one whose worker was lost is put back into the queue by this.

        Raises:
            JobNotFoundError: there is none of that id.
            QueueUnavailableError: Redis fails.
        """
        self.queue.take_back_abandoned([fail_for_good])
        job = self._fetch(job_id)
        status = _STATUS[job.get_status(refresh=False)]
        result = job.return_value() if status == "finished" else None
        if result is None and (status == "finished" or JobKeys(self.connection, job_id).cancel_requested()):
            status = "canceled"
        if status == "failed":
            JobKeys(self.connection, job_id).drop_parcel()
        return JobState(
            id=job_id,
            kind=job.meta.get("kind", "verification"),
            status=status,
            queue_position=self.queue.get_job_position(job) if status == "queued" else None,
            progress=job.meta.get("progress") if status == "started" else None,
            reference=result["reference"] if result else None,
            comparison=result["comparison"] if result else None,
            error=failure_of(job) if status == "failed" else None,
            created_at=job.created_at,
            started_at=job.started_at,
            ended_at=job.ended_at,
        )

    @redis_failures()
    def cancel(self, job_id: str) -> JobState:
        """Cancel a job, queued or running; one that has ended stays as it is.

        A running solve stops at its next report; if its worker is lost, whoever takes the job up finds the request.

        Raises:
            JobNotFoundError: there is none of that id.
            QueueUnavailableError: Redis fails.
        """
        if self.state(job_id).status in ("queued", "started"):
            keys = JobKeys(self.connection, job_id)
            keys.request_cancel(self.settings.retention_s)
            if self.queue.remove(job_id):
                job = self._fetch(job_id)
                job.ended_at = datetime.now(UTC)
                job.save(include_meta=False)
                job.set_status(JobStatus.CANCELED)
                job.cleanup(self.settings.retention_s, remove_from_queue=False)
                keys.drop_parcel()
                end(job, "canceled")
        return self.state(job_id)

    @redis_failures()
    def reference_mask(self, job_id: str) -> bytes:
        """The reference mask of a finished job as a 1-bit PNG file.

        Raises:
            JobNotFoundError: there is no such job, or it has not finished.
            QueueUnavailableError: Redis fails.
        """
        return self._left(
            job_id, JobKeys(self.connection, job_id).reference_mask, "it has a reference mask once it has finished"
        )

    @redis_failures()
    def field(self, job_id: str, name: FieldName) -> bytes:
        """A field of the reference solution that was asked for, an NPY file.

        Raises:
            JobNotFoundError: there is no such job, it has not finished, or the field was not asked for.
            QueueUnavailableError: Redis fails.
        """
        advice = f"it has this field once it has finished, if outputs={name} was asked for"
        return self._left(job_id, JobKeys(self.connection, job_id).fields[name], advice)

    def _left(self, job_id: str, key: str, advice: str) -> bytes:
        """What the worker left under a key."""
        data = self.connection.get(key)
        if not isinstance(data, bytes):
            raise JobNotFoundError(f"Job {job_id} is {self.state(job_id).status}; {advice}.")
        return data

    def check_webhook(self, url: str) -> None:
        """Make sure that a webhook may be sent.

        Raises:
            WebhookError: it may not.
        """
        if self.settings.webhook_secret is None:
            raise WebhookError("This service sends no webhooks: ASPERITY_WEBHOOK_SECRET is not set. Leave webhook_url out.")
        public_address(url, self.settings.webhook_private)

    def _refuse_if_too_large(self, shape: tuple[int, int]) -> None:
        rows, columns = shape
        needed = memory_mib(rows * columns)
        if needed > self.settings.worker_memory_mib:
            raise JobTooLargeError(
                f"The solve of {rows} x {columns} pixels would take about {needed:.0f} MiB, more than the "
                f"{self.settings.worker_memory_mib} MiB of a worker (ASPERITY_WORKER_MEMORY_MIB). Crop or resample the map, "
                "or send verify=false for a prediction alone."
            )

    def _refuse_if_full(self) -> None:
        advice = "try again later, or send verify=false"
        if self.queue.count >= self.settings.queue_length:
            raise QueueFullError(f"{self.settings.queue_length} verifications are waiting; {advice}.")
        used_mib = self.connection.info("memory")["used_memory"] / 2**20
        if used_mib >= self.settings.redis_memory_mib:
            raise QueueFullError(f"Jobs fill {used_mib:.0f} MiB, more than ASPERITY_REDIS_MEMORY_MIB; {advice}.")

    def _fetch(self, job_id: str) -> Job:
        if not is_id(job_id):
            raise JobNotFoundError(f"{job_id!r} is no id of a job; ids have 32 hexadecimal digits.")
        try:
            return Job.fetch(job_id, connection=self.connection, serializer=self.queue.serializer)
        except NoSuchJobError as error:
            days = self.settings.retention_days
            raise JobNotFoundError(f"There is no job {job_id}, or it is gone: jobs are kept for {days:g} days.") from error


MEMORY_MIB, MEMORY_BYTES_A_PIXEL = 260.0, 300.0
"""What the process of a job takes, and its solve by pixel: measured from 64 x 64 to 2048 x 2048 pixels, and not exceeded."""


def memory_mib(pixels: int) -> float:
    """Memory that a reference solve takes, in MiB."""
    return MEMORY_MIB + MEMORY_BYTES_A_PIXEL * pixels / 2**20


_REASONS = {
    "AbandonedJobError": "Its worker was lost again and again.",
    "Work-horse terminated": "The process that ran it was killed again and again, perhaps for want of memory.",
    "JobTimeoutException": "It took longer than a job may (ASPERITY_JOB_TIMEOUT_S).",
}
"""What RQ records of the failures that come from outside a job, and what to say of them."""


def failure_of(job: Job) -> str:
    """Why a job failed: the error and its message."""
    result = job.latest_result()
    recorded = (result and result.exc_string) or "It failed without a word."
    for mark, reason in _REASONS.items():
        if mark in recorded:
            return reason
    return recorded.strip().splitlines()[-1]
