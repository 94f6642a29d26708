import numpy as np
import pytest

from solver.closed_forms import uniform_square_centre_displacement
from solver.influence import free_coefficients


def test_coefficients_of_a_patch_add_up_to_those_of_the_whole_square() -> None:
    """Love's formula is additive: 9 x 9 pixels under unit pressure are one square of side 9."""
    coefficients = free_coefficients((5, 5), (1.0, 1.0))
    quadrant = coefficients.copy()
    quadrant[1:] *= 2
    quadrant[:, 1:] *= 2
    assert quadrant.sum() == pytest.approx(uniform_square_centre_displacement(9.0, 1.0, 1.0), rel=1e-13)


def test_far_coefficients_are_those_of_a_point_force() -> None:
    coefficients = free_coefficients((4096, 4096), (1.0, 1.0))
    distance = np.hypot(4095, 4095)
    point = 1 / (np.pi * distance) * (1 + 1 / (24 * distance**2))
    assert coefficients[-1, -1] == pytest.approx(point, rel=1e-11)
    assert (coefficients > 0).all()
    assert (np.diff(coefficients, axis=0) < 0).all()


@pytest.mark.parametrize("aspect", [20.0, 1 / 20])
def test_swapping_the_directions_transposes_the_coefficients(aspect: float) -> None:
    upright = free_coefficients((7, 12), (aspect, 1.0))
    lying = free_coefficients((12, 7), (1.0, aspect))
    np.testing.assert_allclose(upright, lying.T, rtol=1e-13)


def test_only_the_aspect_of_the_pixels_matters() -> None:
    np.testing.assert_allclose(free_coefficients((6, 6), (2e-6, 1e-6)), free_coefficients((6, 6), (2.0, 1.0)), rtol=1e-12)
