"""The worker process: takes verifications from the queue, or shards of data sets if there are none, each in a forked child.

A child forked after multi-threaded numerical work can deadlock. The worker itself does none, and torch is not even imported;
but what all solves share is built before they are forked.
"""

import logging
import os
from typing import Any

from redis import Redis
from rq import Queue, Worker
from rq.job import Job
from rq.serializers import JSONSerializer

from solver.operators import prepare_multilevel
from worker import verification  # noqa: F401 (imported here, before the forks, so that no job waits for it)
from worker.connection import PATIENTLY, client, connect
from worker.ending import end, fail_for_good
from worker.job_queue import SHARDS, VERIFICATIONS, WEBHOOKS, JobQueue
from worker.lifetime import die_with_parent
from worker.logs import log_as_json, request_id
from worker.settings import Settings
from worker.tracing import send_traces, span

HEARTBEAT_EVERY_S = 5
ABANDONED_AFTER_S = 20
"""Without a heartbeat for so long a job counts as abandoned and is queued again."""

MAINTENANCE_EVERY_S = 10
NICE = 10


class VerificationWorker(Worker):
    """An RQ worker whose jobs die with it, and whose loss is noticed within half a minute."""

    def __init__(self, connection: Redis) -> None:
        super().__init__(
            [JobQueue(connection, name=name) for name in (WEBHOOKS, VERIFICATIONS, SHARDS)],
            connection=connection,
            queue_class=JobQueue,
            serializer=JSONSerializer,
            exception_handlers=[fail_for_good],
            job_monitoring_interval=HEARTBEAT_EVERY_S,
            maintenance_interval=MAINTENANCE_EVERY_S,
            worker_ttl=MAINTENANCE_EVERY_S + 15,  # RQ waits 15 s less for the next job
        )
        self.process_id = os.getpid()

    def get_heartbeat_ttl(self, job: Job) -> int:
        """Seconds after which a job without heartbeat is abandoned; RQ's own answer is a minute more."""
        return ABANDONED_AFTER_S

    def prepare_job_execution(self, job: Job, remove_from_intermediate_queue: bool = False) -> None:
        """Besides RQ's own: from now on the job is kept by the registry of those that were started."""
        super().prepare_job_execution(job)
        JobQueue(self.connection, name=job.origin).taken.forget(job.id)

    def handle_job_failure(self, job: Job, *arguments: Any, **named: Any) -> None:
        """Before RQ's own: a job that fails for good is counted and announced."""
        if job.origin == VERIFICATIONS and not job.should_retry:
            end(job, "failed")
        super().handle_job_failure(job, *arguments, **named)

    def main_work_horse(self, job: Job, queue: Queue) -> None:
        """The forked child: it ends with its worker, also if that is killed."""
        die_with_parent(self.process_id)
        request_id.set(job.meta.get("request_id"))
        super().main_work_horse(job, queue)

    def perform_job(self, job: Job, queue: Queue) -> bool:
        """In the child: as a span of the trace in which the job was queued."""
        with span(job.description or job.id, job.meta.get("trace", {})):
            return super().perform_job(job, queue)


def run_worker(settings: Settings) -> None:
    """Work until told to stop (SIGINT or SIGTERM: after the current job).

    Raises:
        QueueUnavailableError: Redis does not answer.
    """
    log_as_json()
    os.nice(NICE)  # whoever waits for a prediction on the same machine comes first
    logging.getLogger("rq.worker").addFilter(lambda record: "cleaning registries" not in record.getMessage())
    connect(settings)
    send_traces("asperity-worker", at_once=True)
    prepare_multilevel()
    VerificationWorker(client(settings, PATIENTLY)).work(logging_level="INFO")
