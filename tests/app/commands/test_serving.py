"""`asperity serve` and `asperity worker`."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.app.conftest import ASPERITY, free_port, run, wait_until_ready


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
