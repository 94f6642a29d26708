from dataclasses import replace

import numpy as np
import pytest

from solver import ContactProblem, InvalidProblemError, constriction_resistance, random_midpoint_displacement, solve
from solver.closed_forms import HertzSphere
from solver.errors import InvalidLoadError
from solver.stiffness import barber_resistance, contact_stiffness
from tests.solver.conftest import PAPER_MODULUS

ROUGH = ContactProblem(random_midpoint_displacement(128, seed=1) * 50e-6, (1e-3 / 128, 1e-3 / 128), 30.0, PAPER_MODULUS)


def test_hertz_stiffness() -> None:
    """dF / d delta = 2 E* a."""
    sphere = HertzSphere(radius=10e-3, load=5.0, effective_modulus=100e9)
    size, side = 256, 3 * sphere.contact_radius
    centres = (np.arange(size) + 0.5) / size * side - side / 2
    heights = -np.add.outer(centres**2, centres**2) / (2 * sphere.radius)
    problem = ContactProblem(heights, (side / size, side / size), 5.0, 100e9)
    assert contact_stiffness(problem, solve(problem)) == pytest.approx(2 * 100e9 * sphere.contact_radius, rel=0.01)


def test_stiffness_is_the_slope_of_load_over_approach() -> None:
    """On a rough surface, from two loads 1 % apart; 2 % of difference is what flipping pixels leave."""
    lighter, heavier = (solve(replace(ROUGH, load=load), tolerance=1e-9) for load in (29.85, 30.15))
    slope = 0.3 / (heavier.approach - lighter.approach)
    assert contact_stiffness(ROUGH, solve(ROUGH, tolerance=1e-9)) == pytest.approx(slope, rel=0.02)


def test_barber_gives_the_resistance_of_the_potential_problem() -> None:
    lighter, heavier = (solve(replace(ROUGH, load=load), tolerance=1e-9) for load in (29.85, 30.15))
    mask = solve(ROUGH, tolerance=1e-9).contact_mask
    expected = constriction_resistance(mask, ROUGH.pixel_size, 1.7e-8)
    found = barber_resistance(PAPER_MODULUS, 1.7e-8, (29.85, lighter.approach), (30.15, heavier.approach))
    assert found == pytest.approx(expected, rel=0.02)


def test_equal_loads_and_periodic_surfaces_are_refused() -> None:
    with pytest.raises(InvalidLoadError, match="different"):
        barber_resistance(1e9, 1.0, (1.0, 1e-6), (1.0, 1e-6))
    periodic = replace(ROUGH, boundary="periodic")
    with pytest.raises(InvalidProblemError, match="periodic"):
        contact_stiffness(periodic, solve(periodic))
