"""A real `asperity serve` on a free port with a state directory of its own, for the benchmarks."""

import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import httpx
from PIL import Image

from model.families import Units, simple_problems

START_TIMEOUT_S = 120
SEED = 30_000_000


@contextmanager
def service(**settings: str) -> Iterator[tuple[httpx.Client, int]]:
    """A client of the service and the process id of the latter, which ends with the block.

    Its state is its own unless ASPERITY_STATE_DIR is set.
    """
    with socket.socket() as free, tempfile.TemporaryDirectory(prefix="asperity-") as state:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
        free.close()
        environment = os.environ | {"ASPERITY_PORT": str(port), "ASPERITY_STATE_DIR": state} | settings
        environment.pop("REDIS_URL", None)
        log = (Path(state) / "serve.log").open("wb")
        process = subprocess.Popen(
            [Path(sys.executable).with_name("asperity"), "serve"], env=environment, stdout=log, stderr=log
        )
        client = httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=120)
        try:
            deadline = time.monotonic() + START_TIMEOUT_S
            while not _ready(client):
                if time.monotonic() > deadline or process.poll() is not None:
                    raise RuntimeError((Path(state) / "serve.log").read_text())
                time.sleep(0.1)
            yield client, process.pid
        finally:
            process.terminate()
            process.wait(30)


def _ready(client: httpx.Client) -> bool:
    try:
        return client.get("/readyz").status_code == 200
    except httpx.TransportError:
        return False


def midpoint_upload(size: int, load_n: float) -> tuple[bytes, dict[str, Any]]:
    """A random midpoint surface of 1 mm square as a 16-bit PNG, and the fields that go with it."""
    units = Units()
    (drawn,) = simple_problems("midpoint", size, range(SEED, SEED + 1), (0.5, 0.5), (load_n, load_n), units)
    file = BytesIO()
    Image.fromarray(drawn.codes).save(file, "PNG")
    fields = {
        "load_n": load_n,
        "pixel_size_um": units.side_mm * 1e3 / size,
        "height_range_um": units.height_range_um,
        "effective_modulus_gpa": units.effective_modulus_gpa,
    }
    return file.getvalue(), fields


def post(client: httpx.Client, png: bytes, **fields: Any) -> dict[str, Any]:
    """Ask for a prediction; raises if it is refused."""
    answer = client.post("/v1/predictions", files={"surface": ("map.png", png, "image/png")}, data=fields)
    if answer.status_code != 200:
        raise RuntimeError(answer.text)
    body: dict[str, Any] = answer.json()
    return body


def wait_for_job(client: httpx.Client, job_id: str, timeout_s: float = 600, look_every_s: float = 0.05) -> dict[str, Any]:
    """The job once it has ended."""
    deadline = time.monotonic() + timeout_s
    while True:
        job: dict[str, Any] = client.get(f"/v1/jobs/{job_id}").json()
        if job["status"] in ("finished", "failed", "canceled"):
            return job
        if time.monotonic() > deadline:
            raise TimeoutError(str(job))
        time.sleep(look_every_s)


def memory_gib(pid: int) -> float:
    """Memory of a process and its children, what they share counted once, in GiB (Linux)."""
    family = [pid]
    for one in family:
        with suppress(OSError):  # it has just ended
            for task in Path(f"/proc/{one}/task").iterdir():
                family += map(int, (task / "children").read_text().split())
    kibibytes = 0
    for one in family:
        with suppress(OSError):  # it has just ended
            for line in Path(f"/proc/{one}/smaps_rollup").read_text().splitlines():
                if line.startswith("Pss:"):
                    kibibytes += int(line.split()[1])
    return kibibytes / 2**20
