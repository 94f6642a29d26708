"""A real Redis and real worker processes."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from redis import Redis

from solver import ContactProblem, random_midpoint_displacement
from worker.connection import connect
from worker.embedded_redis import EmbeddedRedis
from worker.jobs import JobState, VerificationQueue
from worker.settings import Settings


@pytest.fixture
def state() -> Iterator[Path]:
    """A state directory with a path short enough for a socket."""
    directory = Path(tempfile.mkdtemp(prefix="asperity-"))
    yield directory
    shutil.rmtree(directory)


@pytest.fixture
def settings(state: Path, monkeypatch: pytest.MonkeyPatch) -> Settings:
    monkeypatch.delenv("REDIS_URL", raising=False)
    return Settings(state_dir=state, queue_length=5)


@pytest.fixture
def connection(settings: Settings) -> Iterator[Redis]:
    with EmbeddedRedis(settings.state_path):
        yield connect(settings)


@pytest.fixture
def queue(connection: Redis, settings: Settings) -> VerificationQueue:
    return VerificationQueue(connection, settings)


@pytest.fixture
def wait_for(queue: VerificationQueue) -> Callable[..., JobState]:
    """Wait until a job fulfils a condition, and give its state then."""

    def wait(job_id: str, condition: Callable[[JobState], bool], timeout_s: float = 120) -> JobState:
        deadline = time.monotonic() + timeout_s
        while not condition(state := queue.state(job_id)):
            assert time.monotonic() < deadline, f"still {state}"
            time.sleep(0.05)
        return state

    return wait


Wait = Callable[..., JobState]


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


def children(process: int) -> list[int]:
    """The processes that the main thread of a process has started and that still run (Linux)."""
    return [int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def runs(process: int) -> bool:
    """Whether a process runs; one that has ended may stay as a zombie until its new parent looks."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(") ")[2][0]
    except FileNotFoundError:
        return False
    return state != "Z"


def rough(size: int, seed: int = 1, load: float = 30.0) -> ContactProblem:
    heights = random_midpoint_displacement(size, seed=seed) * 50e-6
    return ContactProblem(heights, (1e-3 / size, 1e-3 / size), load, 6.843e9)
