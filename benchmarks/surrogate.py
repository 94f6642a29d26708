"""The network alone against this package's own solver stopped as soon as its mask is as good; all cores, features included.

    asperity benchmark surrogate

Random midpoint surfaces under 30 N, free boundary; times are the better of two, operators kept. `stopped` is the solver at
the loosest of a ladder of tolerances at which the Dice of its active set is no lower.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks.cases import midpoint_problem
from model import Surrogate
from model.mask import active
from model.metrics import dice
from solver import ContactProblem, solve
from solver.problem import BoolArray

SIZES = (128, 256, 512, 1024, 2048)
SURFACES = 3
SEED = 30_000_000
LADDER = (1.0, 0.5, 0.3, 0.2, 0.1, 0.07, 0.05, 0.04, 0.03, 0.02, 0.015, 0.01, 0.007, 0.005, 0.003, 0.001, 1e-6)
LOADS = np.geomspace(10, 50, 32)


def main() -> None:
    """Print the tables."""
    surrogate = Surrogate.load()
    columns = "N", "Dice", "features ms", "network ms", "check ms", "stopped at", "Dice, stopped", "stopped ms"
    print(f"| {' | '.join(columns)} | stopped / network alone |")
    print("|---|---|---|---|---|---|---|---|---|")
    tolerances = {}
    for size in SIZES:
        problems = [midpoint_problem(size, 30.0, seed=SEED + i) for i in range(SURFACES)]
        references = [solve(problem).checked().contact_mask for problem in problems]
        estimates = [_timed(surrogate.estimate, problem) for problem in problems]
        ours_dice = _mean_dice(references, [estimate.contact_mask for estimate, _ in estimates])
        for tolerance in LADDER:
            stopped = [_timed(partial(_stopped, tolerance=tolerance), problem) for problem in problems]
            reached = _mean_dice(references, [mask for mask, _ in stopped])
            if reached >= ours_dice:
                break
        tolerances[size] = tolerance
        ours, theirs = (np.mean([ms for _, ms in results]) for results in (estimates, stopped))
        stages = [np.mean([e.timings_ms[stage] for e, _ in estimates]) for stage in ("features", "network", "check")]
        print(
            f"| {size} | {ours_dice:.4f} | {' | '.join(f'{stage:.1f}' for stage in stages)} | {tolerance:g} | {reached:.4f} "
            f"| {theirs:.1f} | {theirs / ours:.2f} |",
            flush=True,
        )

    many = [replace(midpoint_problem(512, 30.0, seed=SEED), load=float(load)) for load in LOADS]
    _, together = _timed(lambda loads: surrogate.estimate_sweep(many[0], loads), [problem.load for problem in many])
    _, one_by_one = _timed(lambda problems: [_stopped(p, tolerances[512]) for p in problems], many)
    times = f"{together:.0f} ms together, {one_by_one:.0f} ms stopped one by one"
    print(f"\n{len(many)} loads of one 512 x 512 surface: {times}, ratio {one_by_one / together:.1f}.")

    print("\nFull solve (1e-6) from the predicted pressure and from the solver's own start:\n")
    print("| N | iterations, own | iterations, predicted | ms, own | ms, predicted without predicting |")
    print("|---|---|---|---|---|")
    for size in (256, 512, 1024):
        problem = midpoint_problem(size, 30.0, seed=SEED)
        pressure = surrogate.estimate(problem).pressure
        own, own_ms = _timed(solve, problem)
        warm, warm_ms = _timed(lambda p, start=pressure: solve(p, initial_pressure=start), problem)
        print(f"| {size} | {own.iterations} | {warm.iterations} | {own_ms:.0f} | {warm_ms:.0f} |", flush=True)


def _stopped(problem: ContactProblem, tolerance: float) -> BoolArray:
    solution = solve(problem, tolerance=tolerance).checked()
    return active(problem, solution.pressure, solution.gap)


def _timed(work: Callable[[Any], Any], argument: Any) -> tuple[Any, float]:
    times = []
    for _ in range(2):
        started = time.perf_counter()
        result = work(argument)
        times.append(time.perf_counter() - started)
    return result, min(times) * 1e3


def _mean_dice(references: list[BoolArray], masks: list[BoolArray]) -> float:
    return float(np.mean([dice(*pair) for pair in zip(references, masks, strict=True)]))


if __name__ == "__main__":
    main()
