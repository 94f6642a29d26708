"""Time of the solver beside that of other packages on random midpoint surfaces, one thread.

    asperity benchmark peers [SIZE ...]

All are asked for 1e-6; behind the best time of three is what an independent check (benchmarks/certificates.py) says of the
pressure. `ours` builds its operators anew in each solve, as the others do; `again` keeps them, as it does when one grid is
solved after another. aspher runs in its fastest modes, single precision; `aspher / ours` compares with the faster one.
"""

import sys
import time

import numpy as np

from benchmarks.cases import midpoint_problem
from benchmarks.certificates import violation
from benchmarks.one_thread import one_thread
from benchmarks.peer_process import PeerProcess
from solver import ContactProblem, convolution, full_contact, hierarchy, influence, operators, solve, transfer

TOLERANCE = 1e-6
ASPHER = ("aspher, FFT, single", "aspher, H2, single")
OTHERS = ("slippy", "ContactMechanics", "Tamaas")
CASES = (("free", 30.0), ("free", 200.0), ("free", 1000.0), ("free", 1e5), ("periodic", 30.0), ("periodic", 1e5))
SLOW_FROM = 512
"""Pixels a side where the others are run at 30 N alone; beyond it, where they take minutes, not at all."""


def _forget() -> None:
    """Drop what was kept from earlier solves."""
    for module in (convolution, full_contact, hierarchy, influence, operators, transfer):
        for value in vars(module).values():
            if hasattr(value, "cache_clear"):
                value.cache_clear()


def _best(problem: ContactProblem, keep: bool) -> tuple[float, np.ndarray]:
    times: list[float] = []
    while len(times) < 3 and sum(times) < 10:
        if not keep:
            _forget()
        started = time.perf_counter()
        solution = solve(problem, tolerance=TOLERANCE)
        times.append(time.perf_counter() - started)
    return min(times), solution.pressure


def main() -> None:
    """Print a table, one case a row."""
    peers = {name: PeerProcess(name, 600.0) for name in (*ASPHER, *OTHERS)}
    print(f"| N | boundary | load N | contact | ours | again | {' | '.join(peers)} | aspher / ours | aspher / again |")
    print("|---|---|---|---|---|---|" + "---|" * len(peers) + "---|---|")
    for size in map(int, sys.argv[1:] or ("128", "256", "512", "1024")):
        for boundary, load in CASES:
            _row(peers, midpoint_problem(size, load, boundary))  # type: ignore[arg-type]
    for peer in peers.values():
        peer.close()


def _row(peers: dict[str, PeerProcess], problem: ContactProblem) -> None:
    size = problem.shape[0]
    unhurried = size < SLOW_FROM or (size == SLOW_FROM and problem.load == CASES[0][1])
    cold, pressure = _best(problem, keep=False)
    warm, _ = _best(problem, keep=True)
    cells = [f"{cold:.3f} ({violation(problem, pressure):.0e})", f"{warm:.3f}"]
    fastest = np.inf
    for name, peer in peers.items():
        if not peer.installed or (name in OTHERS and not unhurried):
            cells.append("")
            continue
        outcome = peer.solve(problem, TOLERANCE, repeats=3)
        if outcome.pressure is None:
            cells.append("" if outcome.kind == "not supported" else outcome.kind)
            continue
        cells.append(f"{outcome.seconds:.3f} ({violation(problem, outcome.pressure):.0e})")
        if name in ASPHER:
            fastest = min(fastest, outcome.seconds)
    fraction = float((pressure > 0).mean())
    print(
        f"| {size} | {problem.boundary} | {problem.load:g} | {fraction:.1%} | {' | '.join(cells)} "
        f"| {fastest / cold:.1f} | {fastest / warm:.1f} |",
        flush=True,
    )


if __name__ == "__main__":
    one_thread()
    main()
