"""Contact physics and numerics of rough surfaces."""

from solver.errors import AsperityError, InvalidProblemError
from solver.midpoint import random_midpoint_displacement
from solver.problem import ContactProblem, effective_modulus
from solver.resistance import boyer_resistance, constriction_resistance
from solver.solution import Solution, Status
from solver.solve import solve
from solver.spectral import spectral_surface

__all__ = [
    "AsperityError",
    "ContactProblem",
    "InvalidProblemError",
    "Solution",
    "Status",
    "boyer_resistance",
    "constriction_resistance",
    "effective_modulus",
    "random_midpoint_displacement",
    "solve",
    "spectral_surface",
]
