import os
import subprocess
import sys

SCRIPT = """
import os, numpy as np
from solver import ContactProblem, random_midpoint_displacement, solve
problem = ContactProblem(random_midpoint_displacement(512, seed=1) * 50e-6, (2e-6, 2e-6), 30.0, 6.843e9)
here = solve(problem, tolerance=1e-8)
child = os.fork()
if child == 0:
    there = solve(problem, tolerance=1e-8)
    os._exit(int((there.contact_mask != here.contact_mask).any()))
_, status = os.waitpid(child, 0)
print(os.waitstatus_to_exitcode(status), here.contact_mask.sum(), here.converged)
"""


def test_any_number_of_threads_gives_one_mask_also_in_a_forked_process() -> None:
    said = {
        subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env=os.environ | {"OMP_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            timeout=60,
            check=True,
        ).stdout
        for threads in ("1", "2", "3")
    }
    assert len(said) == 1
    code, _, converged = said.pop().split()
    assert (code, converged) == ("0", "True")
