"""A running service for the tests of the application: real Redis, real worker, real weights."""

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.app.files import surface_png

ASPERITY = Path(sys.executable).with_name("asperity")
START_TIMEOUT_S = 60
UNITS = {"load_n": "20", "pixel_size_um": "15.625", "height_range_um": "50", "effective_modulus_gpa": "6.843"}
"""A map of 64 x 64 pixels with these is 1 mm wide."""

Job = dict[str, Any]


@pytest.fixture
def anyio_backend() -> str:
    return "asyncio"


@pytest.fixture(scope="session")
def server() -> Iterator[str]:
    """URL of `asperity serve` with a state of its own."""
    with serving(ASPERITY_UPLOAD_LIMIT_MIB="4") as url:
        yield url


@contextmanager
def serving(**settings: str) -> Iterator[str]:
    """URL of `asperity serve` with these settings and a state of its own."""
    with tempfile.TemporaryDirectory(prefix="asperity-") as state:
        port = free_port()
        environment = (
            os.environ
            | {
                "ASPERITY_STATE_DIR": state,
                "ASPERITY_PORT": str(port),
            }
            | settings
        )
        environment.pop("REDIS_URL", None)
        process = subprocess.Popen([ASPERITY, "serve"], env=environment)
        try:
            url = f"http://127.0.0.1:{port}"
            wait_until_ready(url, process)
            yield url
        finally:
            process.send_signal(signal.SIGTERM)
            assert process.wait(30) == 0


@pytest.fixture(scope="session")
def client(server: str) -> Iterator[httpx.Client]:
    """HTTP client of the running service."""
    with httpx.Client(base_url=server, timeout=60) as client:
        yield client


@pytest.fixture(scope="session")
def predict(client: httpx.Client) -> Callable[..., httpx.Response]:
    """Upload a height map; fields are added to UNITS, or dropped where None."""

    def post(surface: bytes = surface_png(), **fields: str | None) -> httpx.Response:
        data = {name: value for name, value in (UNITS | {"verify": "false"} | fields).items() if value is not None}
        return client.post("/v1/predictions", data=data, files={"surface": ("surface.png", surface, "image/png")})

    return post


@pytest.fixture(scope="session")
def finish(client: httpx.Client) -> Callable[[str], Job]:
    """Follow a job until it ends."""

    def follow(url: str) -> Job:
        while (job := client.get(url).json())["status"] in ("queued", "started"):
            time.sleep(0.1)
        return job

    return follow


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def wait_until_ready(url: str, process: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < deadline:
        assert process.poll() is None, "asperity serve ended"
        try:
            response = httpx.get(f"{url}/readyz")
        except httpx.TransportError:
            time.sleep(0.1)
            continue
        assert response.status_code == 200, response.text
        return
    pytest.fail("asperity serve did not start")


def run(*arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run `asperity` with these arguments."""
    wide = {"COLUMNS": "200", "TERMINAL_WIDTH": "200"}
    return subprocess.run(
        [ASPERITY, *arguments], env=os.environ | wide | environment, capture_output=True, text=True, check=False
    )
