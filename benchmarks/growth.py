"""Time and memory of a solve against the size of the map, and one thread against two.

    asperity benchmark growth [SIZE ...]

Random midpoint surfaces under 30 N, free boundary, tolerance 1e-6. Each solve runs in a process of its own, operators
included; `second` is the solve after the first, with the operators kept.
"""

import os
import resource
import subprocess
import sys
import time

from benchmarks.cases import midpoint_problem
from solver import solve

LOAD = 30.0


def main() -> None:
    """Print a table, one size a row."""
    print("| N | threads | iterations | residual | status | first s | second s | peak memory GiB |")
    print("|---|---|---|---|---|---|---|---|")
    for size in sys.argv[1:] or ("512", "1024", "2048", "4096"):
        for threads in ("1", "2"):
            environment = os.environ | {"OMP_NUM_THREADS": threads}
            subprocess.run([sys.executable, __file__, "--one", size], env=environment, check=True)


def _one(size: int) -> None:
    problem = midpoint_problem(size, LOAD)
    times = []
    for _ in range(4 if size < 4096 else 2):
        started = time.perf_counter()
        solution = solve(problem)
        times.append(time.perf_counter() - started)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"| {size} | {os.environ['OMP_NUM_THREADS']} | {solution.iterations} | {solution.residual:.0e} "
        f"| {solution.status.name} | {times[0]:.2f} | {min(times[1:]):.2f} | {memory:.1f} |",
        flush=True,
    )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        _one(int(sys.argv[2]))
    else:
        main()
