"""Faults while solves wait and run: a worker, the Redis or the service killed, a full disk, a clock that jumps.

    asperity benchmark faults

`lost` are jobs that did not finish, `wrong` those whose mask is not, bit for bit, that of the same solve without a fault;
`answers` are those to predictions asked for all the while. A full disk needs the right to mount a tmpfs, a jumping clock a
C compiler, for a library that all processes are started with; without them these are left out.
"""

import os
import shutil
import signal
import subprocess
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import httpx

from benchmarks.service import midpoint_upload, service, wait_for_job

SIZE = 256
COMPILER = shutil.which("cc")
LOADS_N = [10.0 + 5 * step for step in range(12)]
DISK_MIB = 96
FULL_S = 15.0
JUMPED_S = 15.0

CLOCK = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>

static long offset(void) {
    long seconds = 0;
    FILE *file = fopen(getenv("CLOCK_OFFSET"), "r");
    if (file) { if (fscanf(file, "%ld", &seconds) != 1) seconds = 0; fclose(file); }
    return seconds;
}
int clock_gettime(clockid_t clock, struct timespec *now) {
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
    int failed = real(clock, now);
    if (!failed && clock == CLOCK_REALTIME) now->tv_sec += offset();
    return failed;
}
time_t time(time_t *result) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (result) *result = now.tv_sec;
    return now.tv_sec;
}
int gettimeofday(struct timeval *restrict now, void *restrict zone) {
    struct timespec exact;
    int failed = clock_gettime(CLOCK_REALTIME, &exact);
    now->tv_sec = exact.tv_sec;
    now->tv_usec = exact.tv_nsec / 1000;
    return failed;
}
"""
"""The time of day, with an offset that a file holds."""

Fault = Callable[[int, Path], None]


def main() -> None:
    """Print how many jobs were lost or wrong."""
    with TemporaryDirectory(prefix="asperity-") as state, service(ASPERITY_STATE_DIR=state) as (client, _):
        reference = [_mask(client, job_id) for job_id in _queued(client)]
    faults: dict[str, Fault] = {
        "worker killed": _kill_worker,
        "Redis killed": _kill_redis,
        "service killed": _kill_service,
        "disk full": _fill_disk,
        "clock jumps": _jump,
    }
    print("| fault | jobs | lost | wrong | answers |\n|---|---|---|---|---|")
    for name, fault in faults.items():
        if (fault is _fill_disk and os.geteuid() != 0) or (fault is _jump and not COMPILER):
            print(f"| {name} | left out | | | |")
            continue
        masks, answers = _suffered(fault)
        lost = sum(mask is None for mask in masks)
        wrong = sum(mask not in (None, right) for mask, right in zip(masks, reference, strict=True))
        told = ", ".join(f"{count} x {answer}" for answer, count in sorted(answers.items()))
        print(f"| {name} | {len(masks)} | {lost} | {wrong} | {told} |", flush=True)


def _suffered(fault: Fault) -> tuple[list[bytes | None], Counter[str]]:
    """Masks of the jobs that went through a fault, and what predictions were answered meanwhile."""
    with ExitStack() as stack:
        state = Path(stack.enter_context(TemporaryDirectory(prefix="asperity-")))
        settings = {"ASPERITY_STATE_DIR": str(state)}
        if fault is _fill_disk:
            stack.enter_context(_small_disk(state))
        if fault is _jump:
            _set_clock(state, 0)
            settings |= {"LD_PRELOAD": str(_clock_library(state)), "CLOCK_OFFSET": str(state / "clock")}
        client, pid = stack.enter_context(service(**settings))
        ids = _queued(client)
        while client.get(f"/v1/jobs/{ids[1]}").json()["status"] != "started":
            time.sleep(0.01)
        answers: Counter[str] = Counter()
        with _asking(str(client.base_url), answers):
            fault(pid, state)
        if fault is _kill_service:
            client, pid = stack.enter_context(service(**settings))
        return [_mask(client, job_id) for job_id in ids], answers


def _queued(client: httpx.Client) -> list[str]:
    ids = []
    for load in LOADS_N:
        png, fields = midpoint_upload(SIZE, load)
        answer = client.post("/v1/solves", files={"surface": png}, data={name: str(one) for name, one in fields.items()})
        ids.append(answer.json()["job"]["job_id"])
    return ids


def _mask(client: httpx.Client, job_id: str) -> bytes | None:
    """The mask of a job once it has ended; None if it has none."""
    try:
        job = wait_for_job(client, job_id, timeout_s=180)
    except TimeoutError:
        return None
    return client.get(f"/v1/jobs/{job_id}/mask.png").content if job["status"] == "finished" else None


@contextmanager
def _asking(url: str, answers: Counter[str]) -> Iterator[None]:
    """Ask for predictions, each of another load, and count the answers."""
    stop = threading.Event()

    def ask() -> None:
        load = 10.0
        while not stop.wait(0.2):
            load += 0.01
            png, fields = midpoint_upload(128, load)
            data = {name: str(one) for name, one in fields.items()} | {"verify": "false"}
            try:
                answer = httpx.post(f"{url}/v1/predictions", files={"surface": png}, data=data, timeout=30)
                answers[str(answer.status_code)] += 1
            except httpx.TransportError:
                answers["no connection"] += 1

    asker = threading.Thread(target=ask)
    asker.start()
    yield
    stop.set()
    asker.join()


def _kill_worker(pid: int, _: Path) -> None:
    _kill(_child(pid, "worker"))
    time.sleep(3)


def _kill_redis(pid: int, _: Path) -> None:
    _kill(_child(pid, "redis"))
    time.sleep(3)


def _kill_service(pid: int, _: Path) -> None:
    _kill(pid)
    time.sleep(1)


def _fill_disk(_: int, state: Path) -> None:
    """To the last byte, for a while."""
    ballast = state / "ballast"
    with ballast.open("wb", buffering=0) as file:
        for size in (2**20, 2**12, 1):
            try:
                while file.write(bytes(size)):
                    pass
            except OSError:
                continue
    time.sleep(FULL_S)
    ballast.unlink()


def _jump(_: int, state: Path) -> None:
    """Two hours on, then one back."""
    for hours in (2, 1):
        _set_clock(state, hours)
        time.sleep(JUMPED_S)


def _set_clock(state: Path, hours: int) -> None:
    (state / "clock.new").write_text(str(3600 * hours))
    (state / "clock.new").rename(state / "clock")


def _clock_library(place: Path) -> Path:
    assert COMPILER is not None
    source, library = place / "clock.c", place / "clock.so"
    source.write_text(CLOCK)
    subprocess.run([COMPILER, "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"], check=True)
    return library


@contextmanager
def _small_disk(place: Path) -> Iterator[None]:
    subprocess.run(["/bin/mount", "-t", "tmpfs", "-o", f"size={DISK_MIB}m", "tmpfs", place], check=True)
    try:
        yield
    finally:
        subprocess.run(["/bin/umount", "--lazy", place], check=True)


def _child(pid: int, mark: str) -> int:
    """A child of a process, by a word of its command line (Linux)."""
    for task in Path(f"/proc/{pid}/task").iterdir():
        for child in (task / "children").read_text().split():
            if mark in Path(f"/proc/{child}/cmdline").read_text():
                return int(child)
    raise RuntimeError(f"{pid} has no child {mark}")


def _kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)


if __name__ == "__main__":
    main()
