"""The RQ queues: of verifications, and of shards of data sets."""

from typing import Any

from redis import Redis
from rq import Queue, Retry
from rq.serializers import JSONSerializer

VERIFICATIONS = "asperity"
SHARDS = "asperity-shards"
"""Workers take from this queue when no verification waits."""

WEBHOOKS = "asperity-webhooks"
"""Workers take from this queue first."""

MAINTENANCE_LOCK_S = 10

RETRIES = 3
"""How often a job is taken up again after its worker was lost, before it counts as failed."""


class JobQueue(Queue):
    """A queue of JSON jobs, never pickles, that soon takes back the jobs of lost workers."""

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
        retry: Retry | None = None,
    ) -> None:
        """Queue a call; what becomes of it is kept for so long, and a worker that is lost costs one of its retries."""
        self.enqueue_call(
            function,
            args=args,
            job_id=job_id,
            description=description,
            meta=meta,
            retry=retry or Retry(max=RETRIES),
            result_ttl=keep_s,
            failure_ttl=keep_s,
        )

    def acquire_maintenance_lock(self) -> bool:
        """Whether the caller may look for abandoned jobs; RQ's own lock outlives a holder that is killed by 15 minutes."""
        return bool(self.connection.set(self.registry_cleaning_key, 1, nx=True, ex=MAINTENANCE_LOCK_S))

    def take_up_scheduled(self) -> None:
        """Queue the jobs whose pause before another try is over."""
        for job_id in self.scheduled_job_registry.get_jobs_to_schedule():
            job = self.fetch_job(job_id)
            if job is not None and self.scheduled_job_registry.remove(job):  # or another worker was quicker
                self.enqueue_job(job)

    def take_back_abandoned(self) -> None:
        """Queue again the jobs whose workers have stopped their heartbeat."""
        if self.acquire_maintenance_lock():
            self.started_job_registry.cleanup()
            self.release_maintenance_lock()
