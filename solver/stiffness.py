"""Contact stiffness, and the contact resistance that follows from it: current and load find the same constriction.

Source: Barber 2003, doi:10.1098/rspa.2002.1038.
"""

import numpy as np

from solver.errors import InvalidLoadError, InvalidProblemError
from solver.problem import ContactProblem
from solver.resistance import constriction_current
from solver.solution import Solution


def contact_stiffness(problem: ContactProblem, solution: Solution) -> float:
    """Load a unit of approach, dF / d delta, in N/m: that of a rigid punch with the contact mask for its face.

    An infinitesimal load leaves the mask as it is, so this is the stiffness of the rough contact itself. With a hardness it
    is the stiffness of unloading.

    Raises:
        InvalidProblemError: a periodic boundary, on which the displacement of the mean is not defined.
        NotConvergedError: see :func:`solver.resistance.constriction_current`.
    """
    if problem.boundary == "periodic":
        raise InvalidProblemError("A periodic surface has no stiffness: its mean displacement is not defined.")
    current = constriction_current(solution.contact_mask, problem.pixel_size)
    return problem.effective_modulus * float(np.sqrt(problem.pixel_area) * current.sum())


def barber_resistance(
    effective_modulus: float, resistivity: float, first: tuple[float, float], second: tuple[float, float]
) -> float:
    """Contact resistance in ohm between two loads, from the approaches that they lead to, without a potential problem.

    Args:
        effective_modulus: E* in Pa.
        resistivity: mean resistivity of the two bodies, in ohm m.
        first, second: load in N and approach in m of one surface; close, for the result belongs to a load between.

    Raises:
        InvalidLoadError: two equal loads.
    """
    (load_1, approach_1), (load_2, approach_2) = first, second
    if load_1 == load_2:
        raise InvalidLoadError(f"Both loads are {load_1:g} N; a resistance follows from two different ones.")
    return resistivity * effective_modulus * (approach_2 - approach_1) / (load_2 - load_1)
