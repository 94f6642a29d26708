"""The queue with real workers: canceled, refused, taken back."""

import json
import subprocess
import sys
import time
import zlib

import numpy as np
import pytest
from redis import Redis
from rq import Worker

from tests.worker.conftest import Wait, ended, rough, started, worker
from worker.connection import connect
from worker.embedded_redis import EmbeddedRedis
from worker.errors import JobNotFoundError, JobTooLargeError, QueueFullError, QueueUnavailableError
from worker.jobs import VerificationQueue, memory_mib
from worker.parcel import JobKeys, Parcel
from worker.settings import Settings


def test_a_job_that_waits_is_canceled_and_never_run(queue: VerificationQueue, settings: Settings, wait_for: Wait) -> None:
    problem, mask = rough(32), np.ones((32, 32), dtype=bool)
    job_id = queue.enqueue(Parcel(problem, mask, None))
    assert queue.cancel(job_id).status == "canceled"
    with worker(settings):
        assert wait_for(queue.enqueue(Parcel(problem, mask, None)), ended).status == "finished"
    assert queue.state(job_id).status == "canceled"
    with pytest.raises(JobNotFoundError, match="canceled"):
        queue.reference_mask(job_id)


def test_a_job_that_runs_is_canceled_and_its_worker_goes_on(
    queue: VerificationQueue, settings: Settings, wait_for: Wait
) -> None:
    with worker(settings):
        long = queue.enqueue(Parcel(rough(1024, load=2000.0), np.ones((1024, 1024), dtype=bool), None))
        assert wait_for(long, started).progress["residual"] > 0  # type: ignore[index]
        assert queue.cancel(long).status == "canceled"
        short = queue.enqueue(Parcel(rough(32), np.ones((32, 32), dtype=bool), None))
        assert wait_for(short, ended, timeout_s=30).status == "finished"
    assert queue.state(long).status == "canceled"
    assert queue.cancel(short).status == "finished"


def test_the_queue_outlives_its_redis(settings: Settings) -> None:
    with EmbeddedRedis(settings.state_path):
        job_id = VerificationQueue(connect(settings), settings).enqueue(Parcel(rough(32)))
    with EmbeddedRedis(settings.state_path), worker(settings):
        queue = VerificationQueue(connect(settings), settings)
        deadline = time.monotonic() + 60
        while not ended(queue.state(job_id)):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        assert queue.state(job_id).status == "finished"


def test_asking_for_a_job_whose_worker_is_lost_puts_it_back_into_the_queue(
    queue: VerificationQueue, settings: Settings, connection: Redis, wait_for: Wait
) -> None:
    with worker(settings):
        job_id = queue.enqueue(Parcel(rough(1024, load=2000.0), np.ones((1024, 1024), dtype=bool), None))
        wait_for(job_id, started)
    (execution,) = connection.zrange(queue.queue.started_job_registry.key, 0, -1)
    connection.zadd(queue.queue.started_job_registry.key, {execution: 1})  # its last heartbeat has expired
    assert queue.state(job_id).status == "queued"
    assert queue.queue.count == 1


def test_a_job_that_takes_too_long_fails_at_once_and_says_so(
    queue: VerificationQueue, settings: Settings, connection: Redis, wait_for: Wait
) -> None:
    hasty = VerificationQueue(connection, settings.model_copy(update={"job_timeout_s": 1}))
    with worker(settings):
        state = wait_for(hasty.enqueue(Parcel(rough(1024, load=2000.0))), ended)
        (runner,) = Worker.all(connection)
        assert runner.failed_job_count == 1
    assert state.status == "failed"
    assert state.error == "It took longer than a job may (ASPERITY_JOB_TIMEOUT_S)."
    assert not connection.exists(JobKeys(connection, state.id).parcel)


def test_a_full_queue_refuses(queue: VerificationQueue, settings: Settings) -> None:
    for _ in range(settings.queue_length):
        queue.enqueue(Parcel(rough(16), np.ones((16, 16), dtype=bool), None))
    with pytest.raises(QueueFullError, match="verify=false"):
        queue.enqueue(Parcel(rough(16), np.ones((16, 16), dtype=bool), None))


def test_a_full_memory_refuses(connection: Redis, settings: Settings) -> None:
    queue = VerificationQueue(connection, settings.model_copy(update={"redis_memory_mib": 2}))
    queue.enqueue(Parcel(rough(512), np.ones((512, 512), dtype=bool), None))
    with pytest.raises(QueueFullError, match="ASPERITY_REDIS_MEMORY_MIB"):
        queue.enqueue(Parcel(rough(16), np.ones((16, 16), dtype=bool), None))


def test_what_redis_refuses_makes_the_queue_unavailable(queue: VerificationQueue, connection: Redis) -> None:
    connection.config_set("maxmemory", 1)
    with pytest.raises(QueueUnavailableError, match="maxmemory"):
        queue.enqueue(Parcel(rough(16), np.ones((16, 16), dtype=bool), None))


@pytest.mark.parametrize("job_id", ["0" * 32, "../../etc", "*"])
def test_unknown_jobs_are_not_found(queue: VerificationQueue, job_id: str) -> None:
    for act in (queue.state, queue.cancel, queue.reference_mask):
        with pytest.raises(JobNotFoundError):
            act(job_id)


def test_jobs_are_stored_as_json(queue: VerificationQueue, connection: Redis) -> None:
    job_id = queue.enqueue(Parcel(rough(16), np.ones((16, 16), dtype=bool), None))
    stored = connection.hgetall(f"rq:job:{job_id}")
    assert json.loads(zlib.decompress(stored[b"data"]))[0] == "worker.verification.verify"


def test_a_job_that_would_take_too_much_memory_is_refused_with_the_number(connection: Redis, settings: Settings) -> None:
    small = VerificationQueue(connection, settings.model_copy(update={"worker_memory_mib": 300}))
    small.enqueue(Parcel(rough(256)))
    with pytest.raises(JobTooLargeError, match=r"512 x 512 pixels would take about 335 MiB, more than the 300 MiB"):
        small.enqueue(Parcel(rough(512)))


def test_the_memory_of_a_job_is_not_underestimated() -> None:
    program = (
        "from pathlib import Path; from tests.worker.conftest import rough; from worker.parcel import Parcel\n"
        "from worker.verification import solve_and_compare\n"
        "solve_and_compare(Parcel(rough(512)), lambda *_: None)\n"
        "print(Path('/proc/self/status').read_text().split('VmHWM:')[1].split()[0])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert 100 < int(done.stdout) / 1024 < 1.2 * memory_mib(512 * 512)
