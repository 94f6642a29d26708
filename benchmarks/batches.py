"""Surfaces per second: batches on two processes and on a GPU, beside aspher, one surface after another.

    asperity benchmark batches

Random midpoint surfaces under 10 to 50 N, free boundary, tolerance 1e-6, operators kept; making and storing surfaces is not
counted. aspher runs on one core, as it does in a batch of its own; two processes of it would take half as long.
"""

import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import torch

from benchmarks.cases import midpoint_problem
from benchmarks.one_thread import one_thread
from benchmarks.peer_process import PeerProcess
from solver import ContactProblem
from solver.solve import solve_batch

COUNT, BATCH = 64, 16
LARGE = 512


def _problems(size: int, count: int) -> list[ContactProblem]:
    loads = np.geomspace(10, 50, count)
    return [midpoint_problem(size, float(load), seed=seed) for seed, load in enumerate(loads)]


def _solved(problems: list[ContactProblem]) -> int:
    return sum(solution.converged for solution in solve_batch(problems))


def main() -> None:
    """Print surfaces per second."""
    for size, count, batch in ((128, COUNT, BATCH), (LARGE, 8, 1)):
        problems = _problems(size, count)
        parts = [problems[first : first + batch] for first in range(0, count, batch)]
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            times = []
            for _ in range(4):
                started = time.perf_counter()
                converged = sum(pool.map(_solved, parts))
                times.append(time.perf_counter() - started)
        ours = count / min(times[1:])
        print(f"{size} x {size}: two cores {ours:.1f} surfaces/s, {converged} of {count} converged")
        _beside_aspher(problems, ours)
        if torch.cuda.is_available():
            _on_gpu(size, ours)


def _beside_aspher(problems: list[ContactProblem], ours: float) -> None:
    peer = PeerProcess("aspher, FFT, single", 100.0)
    if not peer.installed:
        return
    seconds = 0.0
    for problem in problems:
        seconds += peer.solve(problem, 1e-6, repeats=2).seconds
    peer.close()
    theirs = len(problems) / seconds
    print(f"  aspher, FFT, single precision, one core: {theirs:.1f} surfaces/s; ours / aspher {ours / theirs:.1f}")


def _on_gpu(size: int, ours: float) -> None:
    problems = _problems(size, 4096 * 128**2 // size**2)
    solve_batch(problems[:8], device="cuda")
    torch.cuda.synchronize()
    started = time.perf_counter()
    converged = sum(solution.converged for solution in solve_batch(problems, device="cuda"))
    rate = len(problems) / (time.perf_counter() - started)
    print(
        f"  {torch.cuda.get_device_name()}: {rate:.0f} surfaces/s, {converged} of {len(problems)} converged; "
        f"GPU / two cores {rate / ours:.0f}"
    )


if __name__ == "__main__":
    one_thread()
    main()
