"""Contact masks beside those of ContactMechanics (free boundary) and Tamaas (periodic), both pushed to 1e-12.

    asperity benchmark agreement

A pixel is marginal if its gap or its pressure lies within 1e-6 of zero, in rms heights and mean contact pressures.
"""

import numpy as np

from benchmarks.cases import midpoint_problem
from benchmarks.peer_process import PeerProcess
from solver import ContactProblem, Solution, solve

TOLERANCE, THEIRS, MARGINAL = 1e-8, 1e-12, 1e-6
SURFACES = 20
SIZES = (64, 128, 256, 512)
LOADS = (1.0, 500.0)


def main() -> None:
    """Print a table, one surface a row."""
    free, periodic = PeerProcess("ContactMechanics", 600.0), PeerProcess("Tamaas", 600.0)
    print("| seed | N | load N | contact | ContactMechanics | multilevel | of these marginal | periodic, Tamaas |")
    print("|---|---|---|---|---|---|---|---|")
    for seed in range(SURFACES):
        size = SIZES[seed % len(SIZES)]
        load = float(np.geomspace(*LOADS, SURFACES)[seed * 7 % SURFACES])
        problem = midpoint_problem(size, load, seed=seed)
        ours, multilevel = solve(problem, tolerance=TOLERANCE).checked(), solve(problem, "multilevel", TOLERANCE)
        flipped = ours.contact_mask != multilevel.contact_mask
        around = midpoint_problem(size, load, "periodic", seed)
        cells = [
            str(_differing(problem, ours, free)),
            f"{flipped.sum()}{'' if multilevel.converged else ' (' + multilevel.status.name + ')'}",
            str((flipped & _marginal(problem, ours)).sum()),
            str(_differing(around, solve(around, tolerance=TOLERANCE).checked(), periodic)),
        ]
        print(f"| {seed} | {size} | {load:.3g} | {ours.contact_fraction:.2%} | {' | '.join(cells)} |", flush=True)
    free.close()
    periodic.close()


def _differing(problem: ContactProblem, ours: Solution, peer: PeerProcess) -> int | str:
    """Pixels that one has in contact and the other has not."""
    outcome = peer.solve(problem, THEIRS)
    if outcome.pressure is None:
        return outcome.kind
    return int(np.count_nonzero(ours.contact_mask != (outcome.pressure > 0)))


def _marginal(problem: ContactProblem, solution: Solution) -> np.ndarray:
    touching = solution.contact_mask
    near = solution.gap < MARGINAL * problem.rms_height
    light = solution.pressure < MARGINAL * solution.pressure[touching].mean()
    return np.where(touching, light, near)


if __name__ == "__main__":
    main()
