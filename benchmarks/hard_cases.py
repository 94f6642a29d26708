"""Hard cases: what this solver and four others return, and what an independent check says of it.

    asperity benchmark hard-cases

Every solver is asked for 1e-6. The check (benchmarks/certificates.py) shares nothing with any of them: an answer is `ok` if
it violates the contact conditions by less than 1e-4, in units of the rms height; `WRONG` if the solver claims convergence
and it does not; `gives up` if the solver says itself that it has not converged. Iterations are in brackets.
"""

from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.cases import HOPELESS, REFUSED, SOLVABLE, USUAL
from benchmarks.certificates import violation
from benchmarks.peer_process import PeerProcess
from solver import AsperityError, ContactProblem, random_midpoint_displacement, solve

TOLERANCE, JUDGED = 1e-6, 1e-4
LIMIT_S = 20.0
OTHERS = ("ContactMechanics", "Tamaas", "aspher", "slippy")


def main() -> None:
    """Print the table, one case and boundary a row."""
    peers = {name: PeerProcess(name, LIMIT_S) for name in OTHERS}
    missing = [name for name, peer in peers.items() if not peer.installed]
    if missing:
        print(f"Not installed, so not run (see benchmarks/peer_solvers.py): {', '.join(missing)}.\n")
    print(f"| case | boundary | contact | fft | multilevel | {' | '.join(OTHERS)} |")
    print("|---|---|---|---|---|" + "---|" * len(OTHERS))
    large = {
        "2048 x 2048": {"heights": random_midpoint_displacement(2048, seed=1) * 50e-6, "pixel_size": (1e-3 / 2048,) * 2}
    }
    rows = [(name, boundary, change, TOLERANCE) for name, change in SOLVABLE.items() for boundary in ("free", "periodic")]
    rows += [(name, "free", change, TOLERANCE) for name, change in (REFUSED | large).items()]
    rows += [(name, "free", change, tolerance) for name, (change, tolerance) in HOPELESS.items()]
    for name, boundary, change, tolerance in tqdm(rows, desc="cases"):
        given = USUAL | change | {"boundary": boundary}
        contact, ours = "", []
        for method in ("fft", "multilevel"):
            if method == "multilevel" and boundary == "periodic":
                ours.append("")
                continue
            cell, fraction = _ours(given, method, tolerance)
            ours.append(cell)
            contact = contact or fraction
        theirs = [_theirs(peer, given, tolerance) if name not in large and peer.installed else "" for peer in peers.values()]
        tqdm.write(f"| {name} | {boundary} | {contact} | {' | '.join(ours)} | {' | '.join(theirs)} |")
    for peer in peers.values():
        peer.close()


def _ours(given: dict[str, Any], method: str, tolerance: float) -> tuple[str, str]:
    """What we return, and the contact fraction."""
    try:
        problem = ContactProblem(**given)
        solution = solve(problem, method, tolerance)  # type: ignore[arg-type]
    except AsperityError as error:
        return f"refused: {error}", ""
    verdict = _verdict(solution.converged, violation(problem, solution.pressure), tolerance)
    return f"{verdict} ({solution.iterations})", f"{solution.contact_fraction:.2%}"


def _theirs(peer: PeerProcess, given: dict[str, Any], tolerance: float) -> str:
    """What a peer returns."""
    outcome = peer(**given, tolerance=tolerance)
    if outcome.pressure is None:
        return {"raised": "refuses"}.get(outcome.kind, outcome.kind)
    try:
        problem = ContactProblem(**given)
    except AsperityError:
        return "WRONG (answers)" if outcome.converged else "gives up"
    return _verdict(outcome.converged, violation(problem, outcome.pressure), tolerance)


def _verdict(claimed: bool, found: float, tolerance: float) -> str:
    if not claimed:
        return f"gives up {found:.0e}"
    return f"ok {found:.0e}" if found <= JUDGED and (found <= tolerance or tolerance >= TOLERANCE) else f"WRONG {found:.0e}"


if __name__ == "__main__":
    with np.errstate(all="ignore"):
        main()
