"""What engineers read off a contact."""

import numpy as np
import pytest

from app.preparation import detrended
from solver import ContactProblem, random_midpoint_displacement, solve
from worker.statistics import resistances, roughness_parameters, solution_of, statistics

PROBLEM = ContactProblem(random_midpoint_displacement(64, seed=3) * 50e-6, (15e-6, 15e-6), 30.0, 6.843e9)
SOLUTION = solve(PROBLEM)


def test_a_solved_pressure_evaluated_again_is_the_solution() -> None:
    again = solution_of(PROBLEM, SOLUTION.pressure)
    np.testing.assert_allclose(again.pressure, SOLUTION.pressure, rtol=1e-12)
    np.testing.assert_allclose(again.gap, SOLUTION.gap, atol=1e-12 * np.ptp(PROBLEM.heights))
    assert again.residual <= 1e-6


def test_a_pressure_that_is_no_solution_says_so() -> None:
    assert solution_of(PROBLEM, np.ones(PROBLEM.shape)).residual > 0.1


def test_numbers_of_a_contact() -> None:
    found = statistics(PROBLEM, SOLUTION)
    area = SOLUTION.contact_fraction * PROBLEM.nominal_area * 1e6
    assert 0 < found.largest_spot_mm2 <= area
    assert found.corrected_contact_area_mm2 < area
    assert found.mean_contact_pressure_gpa * area * 1e3 == pytest.approx(PROBLEM.load, rel=1e-6)
    assert found.approach_um == pytest.approx(SOLUTION.approach * 1e6)
    assert found.contact_spots >= 1


def test_three_resistances_of_one_contact() -> None:
    found = resistances(PROBLEM, SOLUTION, 1e-7)
    assert found.barber_ohm == pytest.approx(found.constriction_ohm, rel=0.05)
    assert found.constriction_ohm < found.boyer_ohm < 1.3 * found.constriction_ohm
    assert found.spread == pytest.approx(found.boyer_ohm / min(found.constriction_ohm, found.barber_ohm) - 1)
    assert found.conductance_s_per_m2 == pytest.approx(1 / (found.constriction_ohm * PROBLEM.nominal_area))


def test_a_periodic_surface_has_neither_stiffness_nor_barbers_resistance() -> None:
    periodic = ContactProblem(PROBLEM.heights, PROBLEM.pixel_size, 30.0, 6.843e9, boundary="periodic")
    solution = solve(periodic)
    assert statistics(periodic, solution).contact_stiffness_n_per_m is None
    assert resistances(periodic, solution, 1e-7).barber_ohm is None


def test_roughness_is_in_micrometres() -> None:
    found = roughness_parameters(PROBLEM)
    assert found.sq_um == pytest.approx(detrended(PROBLEM.heights, "plane").std() * 1e6)
    assert 0 < found.sa_um < found.sq_um
