"""Workers that are kept running, and that end with the service."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
from redis import Redis
from rq import Worker

from tests.worker.conftest import Wait, ended, rough, runs
from worker.jobs import VerificationQueue
from worker.parcel import Parcel
from worker.settings import Settings
from worker.supervisor import WorkerSupervisor


def test_a_supervised_worker_that_dies_is_replaced(queue: VerificationQueue, settings: Settings, wait_for: Wait) -> None:
    with WorkerSupervisor(settings, count=1) as supervisor:
        job_id = queue.enqueue(Parcel(rough(32), np.ones((32, 32), dtype=bool), None))
        assert wait_for(job_id, ended).status == "finished"
        (lost,) = supervisor.processes
        lost.kill()
        lost.wait()
        job_id = queue.enqueue(Parcel(rough(32), np.ones((32, 32), dtype=bool), None))
        assert wait_for(job_id, ended).status == "finished"
        (found,) = supervisor.processes
        assert found.pid != lost.pid
    assert found.poll() is not None


def test_a_worker_that_cannot_be_started_is_tried_again(
    connection: Redis, settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    start, failures = WorkerSupervisor._start, [OSError("no memory"), OSError("no process")]

    def flaky(supervisor: WorkerSupervisor) -> "subprocess.Popen[bytes]":
        if failures:
            raise failures.pop()
        return start(supervisor)

    monkeypatch.setattr(WorkerSupervisor, "_start", flaky)
    with WorkerSupervisor(settings, count=1):
        deadline = time.monotonic() + 60
        while Worker.count(connection) < 1:
            assert time.monotonic() < deadline
            time.sleep(0.05)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux kills children with their parent")
def test_workers_end_when_the_service_is_killed(queue: VerificationQueue, settings: Settings, connection: Redis) -> None:
    launcher = "import time; from worker.settings import Settings; from worker.supervisor import WorkerSupervisor\n"
    launcher += "with WorkerSupervisor(Settings(), count=2): time.sleep(600)"
    environment = os.environ | {"ASPERITY_STATE_DIR": str(settings.state_path)}
    with subprocess.Popen([sys.executable, "-c", launcher], env=environment) as service:
        deadline = time.monotonic() + 60
        while len(workers := Worker.all(connection)) < 2:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        service.kill()
    deadline = time.monotonic() + 10
    while any(runs(worker.pid) for worker in workers):
        assert time.monotonic() < deadline, "workers outlive the service"
        time.sleep(0.05)
