"""What engineers read off a contact, with units in the names; the same for predictions, solves and the command line."""

from dataclasses import replace

from pydantic import BaseModel, Field

from solver import ContactProblem, Solution, boyer_resistance, constriction_resistance, solve
from solver.contact_statistics import conductance_per_area, contact_statistics
from solver.problem import FloatArray
from solver.roughness import roughness
from solver.stiffness import barber_resistance, contact_stiffness

LOAD_STEP = 1.02
"""Ratio of the two loads from whose approaches Barber's analogy makes a resistance."""


class Statistics(BaseModel):
    """Spots, pressures, gaps, energy and stiffness of a contact."""

    corrected_contact_area_mm2: float = Field(description="contact area less what pixels on the outline count too much")
    contact_spots: int = Field(description="sets of pixels in contact that share edges")
    largest_spot_mm2: float
    mean_contact_pressure_gpa: float
    highest_pressure_gpa: float
    mean_gap_um: float
    approach_um: float = Field(description="from the first touch of the undeformed surface")
    elastic_energy_j: float
    contact_stiffness_n_per_m: float | None = Field(description="dF / d approach; null on a periodic boundary")
    residual: float = Field(description="how far pressure and gap are from the contact conditions, dimensionless")


class Resistances(BaseModel):
    """The contact resistance by three ways, and what follows from it."""

    boyer_ohm: float = Field(description="every pixel carries the same current (Eq. 26 of the paper); too high")
    constriction_ohm: float = Field(description="the potential problem solved on the mask")
    barber_ohm: float | None = Field(description="from the approach at two loads; null on a periodic boundary")
    spread: float = Field(description="highest / lowest of the three - 1")
    conductance_s_per_m2: float = Field(description="of the constriction, by nominal area")


class RoughnessParameters(BaseModel):
    """Roughness of the heights as they were pressed, about their mean plane (ISO 25178-2)."""

    sa_um: float
    sq_um: float
    ssk: float
    sku: float
    rms_slope: float
    psd_slope: float = Field(description="exponent of the power spectrum, -2 (1 + Hurst exponent) if self-affine")


def solution_of(problem: ContactProblem, pressure: FloatArray) -> Solution:
    """Gap, approach and residual of a pressure as it is, from one convolution."""
    return solve(problem, initial_pressure=pressure, max_iterations=0)


def statistics(problem: ContactProblem, solution: Solution) -> Statistics:
    """Of a solution, or of a predicted pressure (:func:`solution_of`)."""
    found = contact_statistics(problem, solution)
    return Statistics(
        corrected_contact_area_mm2=found.corrected_area * 1e6,
        contact_spots=len(found.spot_areas),
        largest_spot_mm2=float(found.spot_areas[0]) * 1e6,
        mean_contact_pressure_gpa=found.pressure.mean * 1e-9,
        highest_pressure_gpa=found.pressure.largest * 1e-9,
        mean_gap_um=found.mean_gap * 1e6,
        approach_um=solution.approach * 1e6,
        elastic_energy_j=found.elastic_energy,
        contact_stiffness_n_per_m=contact_stiffness(problem, solution) if problem.boundary == "free" else None,
        residual=solution.residual,
    )


def resistances(problem: ContactProblem, solution: Solution, resistivity: float) -> Resistances:
    """Of a solution, or of a predicted pressure; Barber's takes two solves, which start from it.

    Raises:
        NotConvergedError: one of the solves did not converge.
    """
    mask = solution.contact_mask
    constriction = constriction_resistance(mask, problem.pixel_size, resistivity)
    found = {
        "boyer_ohm": boyer_resistance(mask, problem.pixel_size, resistivity),
        "constriction_ohm": constriction,
        "barber_ohm": _barber(problem, solution.pressure, resistivity) if problem.boundary == "free" else None,
    }
    known = [value for value in found.values() if value is not None]
    return Resistances(
        **found,  # type: ignore[arg-type]
        spread=max(known) / min(known) - 1,
        conductance_s_per_m2=conductance_per_area(constriction, problem),
    )


def roughness_parameters(problem: ContactProblem) -> RoughnessParameters:
    """Of the heights of a problem.

    Raises:
        InvalidHeightsError: a map under 16 pixels a side, or a plane.
    """
    found = roughness(problem.heights, problem.pixel_size)
    return RoughnessParameters(
        sa_um=found.ra * 1e6,
        sq_um=found.rq * 1e6,
        ssk=found.rsk,
        sku=found.rku,
        rms_slope=found.rms_slope,
        psd_slope=found.psd_slope,
    )


def _barber(problem: ContactProblem, pressure: FloatArray, resistivity: float) -> float:
    """Barber's resistance, half a step about the load."""
    states = []
    for factor in (LOAD_STEP**-0.5, LOAD_STEP**0.5):
        near = replace(problem, load=problem.load * factor)
        states.append((near.load, solve(near, initial_pressure=pressure).checked().approach))
    return barber_resistance(problem.effective_modulus, resistivity, *states)
