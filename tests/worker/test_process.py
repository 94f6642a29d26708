"""Worker processes that are lost."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from redis import Redis
from rq.job import Job, JobStatus
from rq.serializers import JSONSerializer

from tests.worker.conftest import Wait, children, ended, rough, runs, started, worker
from worker.jobs import VerificationQueue
from worker.outcomes import Outcomes
from worker.parcel import Parcel
from worker.settings import Settings


def test_a_worker_never_loads_torch() -> None:
    """A fork after multi-threaded torch work deadlocks; what is not there cannot do so."""
    code = "import sys, worker.process; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux kills children with their parent")
def test_a_solve_dies_with_its_worker(queue: VerificationQueue, settings: Settings, wait_for: Wait) -> None:
    with worker(settings) as process:
        wait_for(queue.enqueue(Parcel(rough(1024, load=2000.0), np.ones((1024, 1024), dtype=bool), None)), started)
        (horse,) = children(process.pid)
    deadline = time.monotonic() + 10
    while runs(horse):
        assert time.monotonic() < deadline, "the solve outlives its worker"
        time.sleep(0.05)


def test_a_job_whose_worker_is_killed_is_finished_by_the_next(
    queue: VerificationQueue, settings: Settings, connection: Redis, wait_for: Wait
) -> None:
    problem = rough(1024, load=500.0)
    with worker(settings):
        job_id = queue.enqueue(Parcel(problem, np.ones((1024, 1024), dtype=bool), None))
        wait_for(job_id, started)
    with worker(settings):
        deadline = time.monotonic() + 120
        job = Job.fetch(job_id, connection, JSONSerializer)
        while job.get_status() is not JobStatus.FINISHED:  # asked of RQ, which does not help a lost job by being asked
            assert time.monotonic() < deadline, f"still {job.get_status()}"
            time.sleep(0.2)
    state = queue.state(job_id)
    assert state.status == "finished"
    assert state.reference is not None
    assert state.reference["converged"]


def test_a_job_whose_solve_is_killed_is_taken_up_again_and_in_the_end_fails(
    queue: VerificationQueue, settings: Settings, wait_for: Wait
) -> None:
    with worker(settings) as process:
        job_id = queue.enqueue(Parcel(rough(1024, load=2000.0), np.ones((1024, 1024), dtype=bool), None))
        deadline = time.monotonic() + 120
        while not ended(queue.state(job_id)) and time.monotonic() < deadline:
            for child in children(process.pid):
                os.kill(child, signal.SIGKILL)
            time.sleep(0.1)
        state = queue.state(job_id)
    assert state.status == "failed"
    assert state.error == "The process that ran it was killed again and again, perhaps for want of memory."


def test_a_solve_goes_on_while_its_redis_is_killed_and_started_again(
    queue: VerificationQueue, settings: Settings, connection: Redis, wait_for: Wait
) -> None:
    with worker(settings):
        job_id = queue.enqueue(Parcel(rough(1024, load=500.0)))
        wait_for(job_id, lambda state: state.progress is not None)
        os.kill(connection.info("server")["process_id"], signal.SIGKILL)
        time.sleep(2)
        state = wait_for(job_id, ended)
    assert state.status == "finished"
    assert Outcomes(connection).read().ended == {"finished": 1}
