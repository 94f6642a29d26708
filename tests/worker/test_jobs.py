"""The queue with real workers: finished, canceled, lost and found."""

import json
import os
import signal
import subprocess
import sys
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from redis import Redis

from model import compare
from solver import boyer_resistance, solve
from tests.worker.conftest import rough
from worker.connection import connect
from worker.embedded_redis import EmbeddedRedis
from worker.errors import JobNotFoundError, QueueFullError, QueueUnavailableError
from worker.jobs import JobState, VerificationQueue
from worker.settings import Settings
from worker.supervisor import WorkerSupervisor

Wait = Callable[..., JobState]
COPPER = 1.7e-8


@contextmanager
def worker(settings: Settings) -> Iterator[subprocess.Popen[bytes]]:
    environment = os.environ | {"ASPERITY_STATE_DIR": str(settings.state_path)}
    process = subprocess.Popen([sys.executable, "-m", "worker"], env=environment)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def started(state: JobState) -> bool:
    return state.status == "started" and state.progress is not None


def ended(state: JobState) -> bool:
    return state.status in ("finished", "failed", "canceled")


def test_a_verification_compares_the_prediction_with_a_reference_solve(
    queue: VerificationQueue, settings: Settings, wait_for: Wait
) -> None:
    problem = rough(64)
    truth = solve(problem).contact_mask
    predicted = np.roll(truth, 1, axis=0)
    with worker(settings):
        state = wait_for(queue.enqueue(problem, predicted, COPPER), ended)
        bare = wait_for(queue.enqueue(problem, truth, None), ended)
    assert state.status == "finished"
    assert state.comparison is not None
    assert state.reference is not None
    expected = compare(truth, predicted)
    for name in ("dice", "jaccard", "bf_score", "pixel_accuracy", "area_error"):
        assert state.comparison[name] == pytest.approx(getattr(expected, name))
    resistances = [boyer_resistance(mask, problem.pixel_size, COPPER) for mask in (predicted, truth)]
    assert state.comparison["resistance_error"] == pytest.approx(resistances[0] / resistances[1] - 1)
    assert state.reference["contact_resistance_ohm"] == pytest.approx(resistances[1])
    assert state.reference["contact_area_mm2"] == pytest.approx(truth.mean())
    assert state.reference["converged"]
    assert state.reference["residual"] <= 1e-6
    mask = np.asarray(Image.open(BytesIO(queue.reference_mask(state.id))))
    np.testing.assert_array_equal(mask, truth)
    assert bare.comparison is not None
    assert (bare.comparison["dice"], bare.comparison["resistance_error"]) == (1, None)


def test_a_job_that_waits_is_canceled_and_never_run(queue: VerificationQueue, settings: Settings, wait_for: Wait) -> None:
    problem, mask = rough(32), np.ones((32, 32), dtype=bool)
    job_id = queue.enqueue(problem, mask, None)
    assert queue.cancel(job_id).status == "canceled"
    with worker(settings):
        assert wait_for(queue.enqueue(problem, mask, None), ended).status == "finished"
    assert queue.state(job_id).status == "canceled"
    with pytest.raises(JobNotFoundError, match="canceled"):
        queue.reference_mask(job_id)


def test_a_job_that_runs_is_canceled_and_its_worker_goes_on(
    queue: VerificationQueue, settings: Settings, wait_for: Wait
) -> None:
    with worker(settings):
        long = queue.enqueue(rough(1024, load=500.0), np.ones((1024, 1024), dtype=bool), None)
        assert wait_for(long, started).progress["residual"] > 0  # type: ignore[index]
        assert queue.cancel(long).status == "canceled"
        short = queue.enqueue(rough(32), np.ones((32, 32), dtype=bool), None)
        assert wait_for(short, ended, timeout_s=30).status == "finished"
    assert queue.state(long).status == "canceled"
    assert queue.cancel(short).status == "finished"


def test_a_job_whose_worker_is_killed_is_finished_by_the_next(
    queue: VerificationQueue, settings: Settings, wait_for: Wait
) -> None:
    problem = rough(512, load=200.0)
    with worker(settings) as first:
        job_id = queue.enqueue(problem, np.ones((512, 512), dtype=bool), None)
        wait_for(job_id, started)
        first.send_signal(signal.SIGKILL)
        first.wait()
    with worker(settings):
        state = wait_for(job_id, ended)
    assert state.status == "finished"
    assert state.reference is not None
    assert state.reference["converged"]


def test_a_job_whose_solve_is_killed_is_taken_up_again_and_in_the_end_fails(
    queue: VerificationQueue, settings: Settings, wait_for: Wait
) -> None:
    with worker(settings) as process:
        job_id = queue.enqueue(rough(1024, load=500.0), np.ones((1024, 1024), dtype=bool), None)
        deadline = time.monotonic() + 120
        while not ended(queue.state(job_id)) and time.monotonic() < deadline:
            children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True)  # noqa: S607
            for child in children.stdout.split():
                os.kill(int(child), signal.SIGKILL)
            time.sleep(0.1)
        state = queue.state(job_id)
    assert state.status == "failed"
    assert state.error is not None
    assert "terminated unexpectedly" in state.error


def test_a_supervised_worker_that_dies_is_replaced(queue: VerificationQueue, settings: Settings, wait_for: Wait) -> None:
    with WorkerSupervisor(settings, count=1) as supervisor:
        job_id = queue.enqueue(rough(32), np.ones((32, 32), dtype=bool), None)
        assert wait_for(job_id, ended).status == "finished"
        (lost,) = supervisor.processes
        lost.kill()
        lost.wait()
        job_id = queue.enqueue(rough(32), np.ones((32, 32), dtype=bool), None)
        assert wait_for(job_id, ended).status == "finished"
        (found,) = supervisor.processes
        assert found.pid != lost.pid
    assert found.poll() is not None


def test_the_queue_outlives_its_redis(settings: Settings) -> None:
    with EmbeddedRedis(settings.state_path):
        job_id = VerificationQueue(connect(settings), settings).enqueue(rough(32), np.ones((32, 32), dtype=bool), None)
    with EmbeddedRedis(settings.state_path), worker(settings):
        queue = VerificationQueue(connect(settings), settings)
        deadline = time.monotonic() + 60
        while not ended(queue.state(job_id)):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        assert queue.state(job_id).status == "finished"


def test_a_full_queue_refuses(queue: VerificationQueue, settings: Settings) -> None:
    for _ in range(settings.queue_length):
        queue.enqueue(rough(16), np.ones((16, 16), dtype=bool), None)
    with pytest.raises(QueueFullError, match="verify=false"):
        queue.enqueue(rough(16), np.ones((16, 16), dtype=bool), None)


@pytest.mark.parametrize("job_id", ["0" * 32, "../../etc", "*"])
def test_unknown_jobs_are_not_found(queue: VerificationQueue, job_id: str) -> None:
    for act in (queue.state, queue.cancel, queue.reference_mask):
        with pytest.raises(JobNotFoundError):
            act(job_id)


def test_jobs_are_stored_as_json(queue: VerificationQueue, connection: Redis) -> None:
    job_id = queue.enqueue(rough(16), np.ones((16, 16), dtype=bool), None)
    stored = connection.hgetall(f"rq:job:{job_id}")
    assert json.loads(zlib.decompress(stored[b"data"]))[0] == "worker.verification.verify"


def test_a_redis_that_does_not_answer_is_said_so(settings: Settings) -> None:
    with pytest.raises(QueueUnavailableError, match="asperity serve"):
        connect(settings)
    with pytest.raises(QueueUnavailableError, match="REDIS_URL"):
        connect(settings.model_copy(update={"redis_url": "redis://127.0.0.1:1/0"}))
