"""Kill -9 of the worker during the verification of a 1024 x 1024 map: how long until its job is finished all the same.

asperity benchmark worker-loss
"""

import os
import signal
import time
from pathlib import Path

from benchmarks.service import midpoint_upload, post, service, wait_for_job


def main() -> None:
    """Print the time from the kill to the finished job."""
    png, fields = midpoint_upload(1024, 100.0)
    with service() as (client, pid):
        answer = post(client, png, **fields)
        url = answer["verification"]["url"]
        while not (job := client.get(url).json())["progress"]:
            time.sleep(0.05)
        worker = _worker_of(pid)
        os.kill(worker, signal.SIGKILL)
        killed = time.monotonic()
        print(f"worker {worker} killed with kill -9 at {job['progress']}")
        job = wait_for_job(client, job["id"])
        print(f"{job['status']} {time.monotonic() - killed:.0f} s later: {job['result']['status']}")
        print(f"its solve alone took {job['result']['solve_seconds']:.0f} s")


def _worker_of(pid: int) -> int:
    """The worker among the children of the service."""
    for task in Path(f"/proc/{pid}/task").iterdir():
        for child in (task / "children").read_text().split():
            if b"worker" in Path(f"/proc/{child}/cmdline").read_bytes():
                return int(child)
    raise RuntimeError("the service has no worker")


if __name__ == "__main__":
    main()
