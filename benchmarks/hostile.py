"""Uploads made to exhaust the service: how soon they are refused, and what memory they take meanwhile.

    asperity benchmark hostile

Bombs that unpack to much more than their size, headers of 50 000 x 50 000 pixels, a body without end, and clients that send
next to nothing. Memory is what the service and all its processes take at most beyond what they took before.
"""

import io
import select
import socket
import struct
import threading
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import httpx
import numpy as np

from benchmarks.service import memory_gib, service

SIDE = 50_000
FIELDS = {
    "load_n": "1",
    "pixel_size_um": "1",
    "height_range_um": "1",
    "effective_modulus_gpa": "1",
    "verify": "false",
}
PREFIX = b'--x\r\nContent-Disposition: form-data; name="surface"; filename="a.png"\r\n\r\n'
MULTIPART = {"Content-Type": "multipart/form-data; boundary=x"}
REPEATS = 5
SLOW_CLIENTS = 100


def main() -> None:
    """Print a table."""
    print("| upload | bytes sent | answer | median ms | memory MB |\n|---|---|---|---|---|")
    with service() as (client, pid):
        client.post("/v1/predictions", data=FIELDS | {"height_unit_um": "1"}, files={"surface": _npy(32)})  # all is started
        for name, (path, field, data) in _files().items():
            _report(name, len(data), pid, lambda: client.post(path, data=FIELDS, files={field: data}).status_code)  # noqa: B023
        announced = MULTIPART | {"Content-Length": str(2**40)}
        _report("announced: 1 TiB", 0, pid, lambda: _raw(client, announced, PREFIX))
        sent: list[int] = []
        _report(
            "without end",
            0,
            pid,
            lambda: _endless(client, sent),
            repeats=1,
        )
        print(f"\nOf the body without end {sum(sent) / 2**20:.0f} MiB were sent, of 64 that are allowed.")
        _slow(client, pid)


def _report(name: str, size: int, pid: int, ask: Callable[[], int], repeats: int = REPEATS) -> None:
    times, answers = [], set()
    with _watched(pid) as most:
        for _ in range(repeats):
            started = time.perf_counter()
            answers.add(ask())
            times.append((time.perf_counter() - started) * 1e3)
    told = ", ".join(map(str, sorted(answers)))
    print(f"| {name} | {size} | {told} | {np.median(times):.0f} | {most[0]:.0f} |", flush=True)


@contextmanager
def _watched(pid: int) -> Iterator[list[float]]:
    """Most memory beyond that at the start, in MB."""
    before, most, stop = memory_gib(pid), [0.0], threading.Event()

    def watch() -> None:
        while not stop.wait(0.01):
            most[0] = max(most[0], (memory_gib(pid) - before) * 2**30 / 1e6)

    watcher = threading.Thread(target=watch)
    watcher.start()
    yield most
    stop.set()
    watcher.join()


def _files() -> dict[str, tuple[str, str, bytes]]:
    zeros = zlib.compress(bytes(2**28), 9)
    predictions = {
        "PNG, header of 50 000 x 50 000": _png(SIDE, SIDE, zlib.compress(bytes(1000))),
        "PNG, 64 x 64 that unpack to 256 MiB": _png(64, 64, zeros),
        "TIFF, header of 50 000 x 50 000": _tiff(SIDE),
        "NPY, header of 50 000 x 50 000": _npy(SIDE),
        "text, a number of a million digits": b"1 2\n3 " + b"9" * 10**6,
        "text, a line of a million numbers": b"1 " * 10**6,
    }
    files = {name: ("/v1/predictions", "surface", data) for name, data in predictions.items()}
    for name, members in (("zip of a GiB of zeros", [2**30]), ("zip of 50 000 files", [0] * 50_000)):
        files[name] = "/v1/batches", "archive", _zip(members)
    return files


def _png(columns: int, rows: int, data: bytes) -> bytes:
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", columns, rows, 16, 0, 0, 0, 0)), (b"IDAT", data), (b"IEND", b""))
    packed = [
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in chunks
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


def _tiff(side: int) -> bytes:
    entries = (
        (256, side),
        (257, side),
        (258, 16),
        (259, 1),
        (262, 1),
        (273, 8),
        (277, 1),
        (278, side),
        (279, 2 * side * side),
    )
    directory = b"".join(struct.pack("<HHII", tag, 4, 1, min(value, 2**32 - 1)) for tag, value in entries)
    return b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", len(entries)) + directory + bytes(4)


def _npy(side: int) -> bytes:
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (side, side)})
    return file.getvalue() + np.random.default_rng(1).random(32 * 32).tobytes()


def _zip(members: list[int]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for number, size in enumerate(members):
            archive.writestr(f"{number}.npy", bytes(size))
    return file.getvalue()


def _endless(client: httpx.Client, sent: list[int]) -> int:
    """The status of a request that is sent until the service listens no longer; how much was sent is added to the list."""
    url = client.base_url
    chunk = b"%x\r\n" % 2**16 + bytes(2**16) + b"\r\n"
    with socket.create_connection((url.host, url.port or 80)) as connection:
        connection.sendall(_head(MULTIPART | {"Transfer-Encoding": "chunked"}))
        connection.sendall(b"%x\r\n" % len(PREFIX) + PREFIX + b"\r\n")
        try:
            while True:
                connection.sendall(chunk)
                sent.append(2**16)
                if select.select([connection], [], [], 0)[0]:
                    return int(connection.recv(2**16).split()[1])
        except ConnectionError:
            return 0


def _raw(client: httpx.Client, headers: dict[str, str], body: bytes) -> int:
    """The status that a request is answered with before it is complete."""
    url = client.base_url
    with socket.create_connection((url.host, url.port or 80)) as connection:
        connection.sendall(_head(headers) + body)
        return int(connection.recv(2**16).split()[1])


def _head(headers: dict[str, str]) -> bytes:
    lines = ["POST /v1/predictions HTTP/1.1", "Host: test", *(f"{name}: {value}" for name, value in headers.items())]
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


def _slow(client: httpx.Client, pid: int) -> None:
    """Many clients that begin a request and fall silent: when they are told, and how others fare meanwhile."""
    url = client.base_url
    with _watched(pid) as most:
        connections = [socket.create_connection((url.host, url.port or 80)) for _ in range(SLOW_CLIENTS)]
        started = time.perf_counter()
        for number, connection in enumerate(connections):
            head = _head(MULTIPART | {"Content-Length": "100000"})
            connection.sendall(head[:60] if number % 2 else head + PREFIX)
        times = []
        for _ in range(20):
            asked = time.perf_counter()
            client.get("/healthz").raise_for_status()
            times.append((time.perf_counter() - asked) * 1e3)
        told = []
        for connection in connections:
            connection.settimeout(60)
            answer = connection.recv(2**16)
            told.append(answer.split()[1].decode() if answer else "closed")
            connection.close()
        waited = time.perf_counter() - started
    kinds = ", ".join(f"{told.count(kind)} x {kind}" for kind in sorted(set(told)))
    print(
        f"{SLOW_CLIENTS} clients that fall silent, half of them within the headers: after {waited:.0f} s {kinds}; "
        f"{most[0]:.0f} MB; /healthz meanwhile {np.median(times):.0f} ms, at most {max(times):.0f} ms."
    )


if __name__ == "__main__":
    main()
