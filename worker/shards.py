"""Shards of data sets, made by workers on any machines that reach one Redis."""

import time
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from redis import Redis
from rq import get_current_job
from rq.job import Job, JobStatus

from model.dataset import DatasetConfig, shard_bytes
from model.errors import DatasetError
from worker.connection import redis_failures
from worker.job_queue import SHARDS, JobQueue
from worker.jobs import failure_of
from worker.settings import Settings
from worker.store import new_id

POLL_S = 0.5
KEPT_S = 3600
"""How long a shard waits in Redis for whoever asked for it."""


def make_shard(config: dict[str, Any], start: int, stop: int) -> None:
    """The job: make a shard and leave it in Redis."""
    job = get_current_job()
    if job is None:
        raise RuntimeError("make_shard is a job of RQ")
    data = shard_bytes(DatasetConfig.restored(config), range(start, stop))
    job.connection.set(_key(job.id), data, ex=KEPT_S)


class ShardQueue:
    """Makes shards by workers: a ``model.dataset.Maker``."""

    def __init__(self, connection: Redis, settings: Settings) -> None:
        self.connection = connection
        self.queue = JobQueue(connection, settings.job_timeout_s, SHARDS)

    def __call__(self, config: DatasetConfig, wanted: dict[int, range]) -> Iterator[tuple[int, bytes]]:
        """Queue the shards, and give each as soon as a worker has made it.

        Raises:
            DatasetError: a worker failed.
            QueueUnavailableError: Redis fails.
        """
        with redis_failures():
            waiting = {self._enqueue(config, indices): number for number, indices in wanted.items()}
            try:
                while waiting:
                    self.queue.take_back_abandoned()
                    for job_id in list(waiting):
                        data = self._made(job_id, waiting[job_id])
                        if data is not None:
                            yield waiting.pop(job_id), data
                    time.sleep(POLL_S)
            finally:
                for job_id in waiting:
                    self.queue.remove(job_id)

    def _made(self, job_id: str, number: int) -> bytes | None:
        """The shard of a job, which is then forgotten; None while there is none."""
        job = Job.fetch(job_id, connection=self.connection, serializer=self.queue.serializer)
        status = job.get_status(refresh=False)
        if status is JobStatus.FAILED:
            raise DatasetError(f"A worker could not make shard {number}: {failure_of(job)}")
        data = self.connection.getdel(_key(job_id)) if status is JobStatus.FINISHED else None
        if not isinstance(data, bytes):
            return None
        job.delete()
        return data

    def _enqueue(self, config: DatasetConfig, indices: range) -> str:
        job_id = new_id()
        description = f"{len(indices)} samples of {config.size} x {config.size}"
        call = asdict(config), indices.start, indices.stop
        self.queue.submit("worker.shards.make_shard", job_id, description, KEPT_S, call)
        return job_id


def _key(job_id: str) -> str:
    return f"asperity:shard:{job_id}"
