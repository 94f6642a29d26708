"""Error and time of the multilevel displacement against the exact convolution by transforms, one thread.

    asperity benchmark multilevel

`contact` is the pressure of a random midpoint surface under 30 N, `dense` is random pressure everywhere. Errors are largest
differences, relative to the largest displacement, in double precision.
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.cases import midpoint_problem
from benchmarks.one_thread import one_thread
from solver import solve
from solver.convolution import convolution
from solver.multilevel import Multilevel

SIZES = (256, 512, 1024, 2048)
SETTINGS = ((4, 6), (4, 8), (6, 8), (6, 12), (8, 14))


def main() -> None:
    """Print a table, one setting a row."""
    print("| N | order | tile | error, contact | error, dense | contact ms | dense ms | FFT ms | contact, single ms |")
    print("|---|---|---|---|---|---|---|---|---|")
    for size in SIZES:
        solution = solve(midpoint_problem(size, 30.0))
        contact = solution.pressure / solution.pressure.max()
        dense = np.random.default_rng(0).random((size, size))
        transforms = convolution("free", (size, size), (1.0, 1.0))
        exact = {"contact": transforms(contact), "dense": transforms(dense)}
        by_transforms = _milliseconds(transforms, contact)
        for order, tile in SETTINGS:
            multilevel = Multilevel((size, size), (1.0, 1.0), "float64", order, tile)
            single = Multilevel((size, size), (1.0, 1.0), "float32", order, tile)
            errors = [
                np.abs(multilevel(pressure) - exact[name]).max() / exact[name].max()
                for name, pressure in (("contact", contact), ("dense", dense))
            ]
            places = np.flatnonzero(contact)[np.newaxis]
            between, values = single.between(places), contact.ravel()[places].astype(np.float32)
            print(
                f"| {size} | {order} | {tile} | {errors[0]:.0e} | {errors[1]:.0e} "
                f"| {_milliseconds(multilevel, contact):.1f} | {_milliseconds(multilevel, dense):.1f} | {by_transforms:.1f} "
                f"| {_milliseconds(between, values):.1f} |",
                flush=True,
            )


def _milliseconds(work: Callable[[Any], Any], argument: Any) -> float:
    times = []
    for _ in range(5):
        started = time.perf_counter()
        work(argument)
        times.append(time.perf_counter() - started)
    return min(times) * 1e3


if __name__ == "__main__":
    one_thread()
    main()
