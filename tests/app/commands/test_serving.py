"""`asperity serve` and `asperity worker`."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import pytest

from tests.app.conftest import ASPERITY, UNITS, free_port, run, wait_until_ready
from tests.app.files import surface_png


def test_a_worker_without_a_queue_fails_with_advice(tmp_path: Path) -> None:
    done = run("worker", ASPERITY_STATE_DIR=str(tmp_path))
    assert done.returncode == 1
    assert "asperity serve" in done.stderr


def test_the_command_line_loads_neither_network_nor_server() -> None:
    """A worker forks for each job; a child of a process with torch may deadlock, and every command waits for imports."""
    program = "import sys, app.cli; sys.exit(any(name in sys.modules for name in ('torch', 'openvino', 'fastapi')))"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_a_setting_that_cannot_be_used_is_bad_input() -> None:
    done = run("serve", ASPERITY_PORT="http")
    assert done.returncode == 2
    assert "ASPERITY_PORT" in done.stderr


def test_a_redis_that_cannot_be_meant_is_refused_at_the_start(tmp_path: Path) -> None:
    done = run("serve", REDIS_URL="localhost:6379", ASPERITY_STATE_DIR=str(tmp_path), ASPERITY_WORKERS="0")
    assert done.returncode == 1
    assert "REDIS_URL" in done.stderr


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_serve_ends_with_all_its_processes(tmp_path: Path, signum: signal.Signals) -> None:
    port = free_port()
    settings = {"ASPERITY_STATE_DIR": str(tmp_path), "ASPERITY_PORT": str(port)}
    process = subprocess.Popen([ASPERITY, "serve"], env=os.environ | settings, start_new_session=True)
    wait_until_ready(f"http://127.0.0.1:{port}", process)
    children = [
        pid for task in Path(f"/proc/{process.pid}/task").iterdir() for pid in (task / "children").read_text().split()
    ]
    assert len(children) >= 2
    os.killpg(process.pid, signum)
    assert process.wait(30) == 0
    deadline = time.monotonic() + 10
    while [child for child in children if Path("/proc", child).exists()]:
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.parametrize(("signum", "to_all"), [(signal.SIGTERM, False), (signal.SIGINT, True)], ids=["stopped", "Ctrl-C"])
def test_what_is_being_computed_is_answered_before_the_end(tmp_path: Path, signum: signal.Signals, to_all: bool) -> None:
    port = free_port()
    settings = {"ASPERITY_STATE_DIR": str(tmp_path), "ASPERITY_PORT": str(port)}
    process = subprocess.Popen([ASPERITY, "serve"], env=os.environ | settings, start_new_session=True)
    url = f"http://127.0.0.1:{port}"
    wait_until_ready(url, process)
    request = {"data": UNITS | {"verify": "false", "accuracy": "exact"}, "files": {"surface": surface_png(1024)}}
    with ThreadPoolExecutor(1) as pool:
        asking = pool.submit(httpx.post, f"{url}/v1/predictions", timeout=60, **request)
        time.sleep(0.5)
        assert not asking.done()
        (os.killpg if to_all else os.kill)(process.pid, signum)
        assert asking.result().status_code == 200
    assert process.wait(30) == 0
