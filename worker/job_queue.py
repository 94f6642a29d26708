"""The RQ queues: of verifications, of shards of data sets, and of webhooks."""

import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any, cast

from redis import Redis
from rq import Queue, Retry
from rq.exceptions import DequeueTimeout
from rq.intermediate_queue import IntermediateQueue
from rq.job import Job, JobStatus
from rq.serializers import JSONSerializer
from rq.worker import BaseWorker

VERIFICATIONS = "asperity"
SHARDS = "asperity-shards"
"""Workers take from this queue when no verification waits."""

WEBHOOKS = "asperity-webhooks"
"""Workers take from this queue first."""

MAINTENANCE_LOCK_S = 10
UNSTARTED_S = 5.0
"""A job that was taken and not started within this was taken by a worker that is lost."""

PAUSES_S = (0, 1, 5, 15, 30)
"""Before a job whose worker or Redis was lost is tried again; after the last it counts as failed."""

BELL = "asperity:bell"
"""Wakes workers that wait for a job: a list, because Redis cannot wait for many lists and keep what it takes."""

RINGS = 64
LOOK_EVERY_S = 1.0
SHORTEST_WAIT_S = 0.01
"""Redis takes less than a millisecond for ever."""

SCHEDULE_EVERY_MS = 500
"""Workers look without a bell too: for jobs that are tried again."""


class Taken(IntermediateQueue):
    """Jobs that were taken and not started yet; those whose worker was lost go back, where RQ would have them fail."""

    def cleanup(self, worker: BaseWorker, queue: Queue) -> None:
        """Put back what was seen here before and still is."""
        for job_id in set(self.get_job_ids()):
            job = queue.fetch_job(job_id)
            if job is None or job.get_status() is not JobStatus.QUEUED:
                self.connection.lrem(self.key, 0, job_id)
            elif job_id not in queue.started_job_registry and not self.set_first_seen(job_id):
                first = self.get_first_seen(job_id)
                if first is not None and time.time() - first.timestamp() > UNSTARTED_S:
                    with self.connection.pipeline() as pipeline:
                        self.forget(job_id, pipeline)
                        pipeline.lrem(queue.key, 0, job_id)  # it may have been tried again since
                        queue.push_job_id(job_id, pipeline=pipeline, at_front=True)
                        pipeline.execute()

    def forget(self, job_id: str, pipeline: Redis | None = None) -> None:
        """It was started, or put back."""
        connection = self.connection if pipeline is None else pipeline
        connection.lrem(self.key, 0, job_id)
        connection.delete(self.get_first_seen_key(job_id))


class JobQueue(Queue):
    """A queue of JSON jobs, never pickles, that loses none and soon takes back those of lost workers."""

    def __init__(self, connection: Redis, job_timeout_s: int | None = None, name: str = VERIFICATIONS) -> None:
        super().__init__(name, connection=connection, serializer=JSONSerializer, default_timeout=job_timeout_s)

    def submit(
        self,
        function: str,
        job_id: str,
        description: str,
        keep_s: int,
        args: tuple[object, ...] = (),
        meta: dict[str, Any] | None = None,
        pauses_s: tuple[int, ...] = PAUSES_S,
    ) -> None:
        """Queue a call; what becomes of it is kept for so long, and it is tried again after each of the pauses."""
        self.enqueue_call(
            function,
            args=args,
            job_id=job_id,
            description=description,
            meta=meta,
            retry=Retry(max=len(pauses_s), interval=list(pauses_s)),
            result_ttl=keep_s,
            failure_ttl=keep_s,
        )
        self.connection.lpush(BELL, 1)
        self.connection.ltrim(BELL, 0, RINGS - 1)

    @property
    def taken(self) -> Taken:
        """Jobs that were taken and not started yet."""
        return Taken(self.key, self.connection)

    @property
    def intermediate_queue(self) -> Taken:
        """What RQ calls them."""
        return self.taken

    @classmethod
    def dequeue_any(
        cls, queues: Iterable[Queue], timeout: int | None, connection: Redis, *rest: object, **named: object
    ) -> tuple[Job, Queue] | None:
        """The next job of the first queue that has one, as RQ's own; but with many queues RQ's own loses what it takes.

        Raises:
            DequeueTimeout: there was none for so many seconds.
        """
        ours = cast(list["JobQueue"], list(queues))
        deadline = time.monotonic() + (timeout or 0)
        while True:
            for queue in ours:
                queue.take_up_scheduled()
                while found := cls.lmove(connection, queue.key, None):
                    job_id = found[1].decode()
                    if job := queue.fetch_job(job_id):
                        return job, queue
                    connection.lrem(queue.taken.key, 0, job_id)  # it has expired
            if timeout is None:
                return None
            left = deadline - time.monotonic()
            if left <= 0:
                raise DequeueTimeout(timeout, [queue.key for queue in ours])
            connection.blpop([BELL], max(SHORTEST_WAIT_S, min(left, LOOK_EVERY_S)))

    def acquire_maintenance_lock(self) -> bool:
        """Whether the caller may look for abandoned jobs; RQ's own lock outlives a holder that is killed by 15 minutes."""
        return bool(self.connection.set(self.registry_cleaning_key, 1, nx=True, ex=MAINTENANCE_LOCK_S))

    def take_up_scheduled(self) -> None:
        """Queue the jobs whose pause before another try is over."""
        if not self.connection.set(f"{self.key}:scheduling", 1, nx=True, px=SCHEDULE_EVERY_MS):
            return
        scheduled = self.scheduled_job_registry
        with self.connection.pipeline() as pipeline:
            for job_id in scheduled.get_jobs_to_schedule():
                if job := self.fetch_job(job_id):
                    self._enqueue_job(job, pipeline=pipeline)
                scheduled.remove(job_id, pipeline=pipeline)
            pipeline.execute()

    def take_back_abandoned(self, handlers: Sequence[Callable[..., object]] = ()) -> None:
        """Queue again the jobs whose workers have stopped their heartbeat; the handlers are told of each, as by RQ."""
        if self.acquire_maintenance_lock():
            self.started_job_registry.cleanup(exception_handlers=list(handlers))
            self.release_maintenance_lock()
