"""Latency of one client, throughput of many, and what happens to the service under load.

    asperity benchmark load [SECONDS]

Random midpoint surfaces of 128 x 128 and 512 x 512 pixels under loads of their own, `balanced` unless it says `fast`, which
here is the network, without verification. The bare prediction, in this process, is beside. Wrong answers are those whose
area is not that of the same prediction in this process, of every fiftieth; the lag of the event loop is what /metrics says.
"""

import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from typing import Any

import httpx
import numpy as np
from prometheus_client.parser import text_string_to_metric_families

from app.reading import Files, read_problem
from app.requests import PredictionFields
from benchmarks.cases import midpoint_problem
from benchmarks.service import memory_gib, midpoint_upload, service
from model import Surrogate

SIZES = (128, 512)
ONE_CLIENT = 60
MANY, CROWD = 32, 200

Sample = tuple[float, float]
"""Load in N, contact area in mm^2."""


def main() -> None:
    """Print the tables."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 120.0
    surrogate = Surrogate.load()
    print("| size | bare prediction, median ms | HTTP, median | 99th percentile | overhead |")
    print("|---|---|---|---|---|")
    with service() as (client, pid):
        url = str(client.base_url)
        for size in SIZES:
            bare = _bare(surrogate, size)
            _latencies(url, size, 5, 1.0)
            found = _latencies(url, size, ONE_CLIENT, 2.0)
            middle, high = np.median(found), np.quantile(found, 0.99)
            print(f"| {size} | {bare:.1f} | {middle:.1f} | {high:.1f} | {middle / bare - 1:.0%} |", flush=True)
        print(f"\n128 x 128, answers a second:\n\n| accuracy | one client | {MANY} clients | ratio |\n|---|---|---|---|")
        for accuracy in ("balanced", "fast"):
            alone, many = (_throughput(url, clients, 10.0, accuracy)[0] for clients in (1, MANY))
            print(f"| {accuracy} | {alone:.1f} | {many:.1f} | {many / alone:.2f} |", flush=True)
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as apart:  # so that nothing else runs in it
            rate, failed, samples = apart.submit(_throughput, url, CROWD, seconds).result()
        wrong = sum(not np.isclose(area, _area(surrogate, load), rtol=1e-6) for load, area in samples)
        lags = _lags(client)
        print(
            f"\n{CROWD} clients for {seconds:g} s: {rate:.1f} answers a second, other than 200: {failed}; wrong: {wrong} "
            f"of {len(samples)}; memory of the service and all its processes {memory_gib(pid):.2f} GiB; "
            f"lag of the event loop: {lags}"
        )


def _bare(surrogate: Surrogate, size: int) -> float:
    """Median ms of the prediction alone."""
    times = []
    for i in range(ONE_CLIENT):
        problem = midpoint_problem(size, 30 + i / 7)
        started = time.perf_counter()
        surrogate.predict(problem)
        times.append((time.perf_counter() - started) * 1e3)
    return float(np.median(times[5:]))


def _latencies(url: str, size: int, count: int, first: float) -> list[float]:
    """Milliseconds of requests one after the other, each of another load."""
    png, fields = midpoint_upload(size, 30.0)
    times = []
    with httpx.Client(base_url=url, timeout=60) as client:
        for i in range(count):
            started = time.perf_counter()
            _ask(client, png, fields | {"load_n": 30 + first + i / 9})
            times.append((time.perf_counter() - started) * 1e3)
    return times


def _throughput(url: str, clients: int, seconds: float, accuracy: str = "balanced") -> tuple[float, int, list[Sample]]:
    """Answers a second, how many were not 200, and every fiftieth of them."""
    png, fields = midpoint_upload(128, 30.0)
    deadline = time.monotonic() + seconds

    def run(number: int) -> tuple[int, int, list[Sample]]:
        done = failed = 0
        samples = []
        with httpx.Client(base_url=url, timeout=120, verify=False) as client:  # noqa: S501 (no TLS, and none to prepare)
            while time.monotonic() < deadline:
                load = 10 + 40 * np.random.default_rng([clients, number, done]).random()
                answer = _ask(client, png, fields | {"load_n": load, "accuracy": accuracy})
                done, failed = done + 1, failed + answer.is_error
                if done % 50 == 1 and not answer.is_error:
                    samples.append((load, answer.json()["contact_area_mm2"]))
        return done, failed, samples

    started = time.monotonic()
    with ThreadPoolExecutor(clients) as pool:
        results = list(pool.map(run, range(clients)))
    rate = sum(done for done, _, _ in results) / (time.monotonic() - started)
    return rate, sum(failed for _, failed, _ in results), [sample for _, _, samples in results for sample in samples]


def _ask(client: httpx.Client, png: bytes, fields: dict[str, Any]) -> httpx.Response:
    data = {name: str(value) for name, value in fields.items()} | {"verify": "false"}
    return client.post("/v1/predictions", files={"surface": ("map.png", png)}, data=data)


def _area(surrogate: Surrogate, load: float) -> float:
    """Contact area in mm^2 as this process predicts it."""
    png, fields = midpoint_upload(128, 30.0)
    form = PredictionFields.parse(fields | {"load_n": load})
    problem = read_problem(Files(png), form, load).problem
    return float(surrogate.predict(problem).contact_mask.sum()) * problem.pixel_area * 1e6


def _lags(client: httpx.Client) -> str:
    """Within how many seconds the event loop went on, 99 in 100 times and always."""
    families = {family.name: family for family in text_string_to_metric_families(client.get("/metrics").text)}
    buckets = [one for one in families["asperity_event_loop_lag_seconds"].samples if one.name.endswith("_bucket")]
    counts = {float(one.labels["le"]): one.value for one in buckets}
    most = max(counts.values())
    within = [min(bound for bound, count in counts.items() if count >= share * most) for share in (0.99, 1.0)]
    return f"99 % within {within[0]:g} s, all within {within[1]:g} s"


if __name__ == "__main__":
    main()
