"""From files and forms to SI units: what the file holds, what the request says, and what is missing."""

import numpy as np
import pytest

from app.contact_problem import contact_problem
from app.errors import InvalidFormError
from app.forms import ProblemForm
from app.height_map import HeightMap
from solver import ContactProblem, effective_modulus
from tests.app.files import surface_codes

GIVEN = {"load_n": 20, "pixel_size_um": 2, "height_range_um": 50, "effective_modulus_gpa": 6.843}
IMAGE = HeightMap(surface_codes() / 65535, "PNG", bit_depth=16)
NUMBERS = HeightMap(surface_codes() / 65535, "NPY")
MEASURED = HeightMap(surface_codes() / 65535, "X3P", height_unit=1e-6, pixel_size=(3e-6, 1e-6))
STEEL_ON_COPPER = {
    "youngs_modulus_1_gpa": 200,
    "poissons_ratio_1": 0.3,
    "youngs_modulus_2_gpa": 110,
    "poissons_ratio_2": 0.34,
}


def form(*left_out: str, **more: object) -> ProblemForm:
    return ProblemForm.parse({name: value for name, value in GIVEN.items() if name not in left_out} | more)


def contact_problem_of(given: ProblemForm, *maps: HeightMap) -> ContactProblem:
    return contact_problem(given, given.load_n, *maps)


def test_units_become_si() -> None:
    problem = contact_problem_of(form(hardness_gpa=2), IMAGE)
    assert problem.pixel_size == pytest.approx((2e-6, 2e-6))
    assert np.ptp(problem.heights) == pytest.approx(50e-6)
    assert problem.load == 20
    assert problem.effective_modulus == pytest.approx(6.843e9)
    assert problem.hardness == pytest.approx(2e9)
    assert problem.boundary == "free"


def test_rows_are_y_and_columns_are_x() -> None:
    given = form("pixel_size_um", pixel_size_x_um=1, pixel_size_y_um=3)
    assert contact_problem_of(given, IMAGE).pixel_size == pytest.approx((3e-6, 1e-6))


def test_two_bodies_give_the_effective_modulus() -> None:
    problem = contact_problem_of(form("effective_modulus_gpa", **STEEL_ON_COPPER), IMAGE)
    assert problem.effective_modulus == pytest.approx(effective_modulus(200e9, 0.3, 110e9, 0.34))


def test_one_body_may_be_rigid() -> None:
    given = form("effective_modulus_gpa", **STEEL_ON_COPPER | {"youngs_modulus_2_gpa": "inf"})
    assert contact_problem_of(given, IMAGE).effective_modulus == pytest.approx(200e9 / (1 - 0.09))


def test_a_file_with_units_needs_none() -> None:
    problem = contact_problem_of(form("pixel_size_um", "height_range_um"), MEASURED)
    assert problem.pixel_size == (3e-6, 1e-6)
    assert np.ptp(problem.heights) == pytest.approx(1e-6)


def test_units_of_the_request_count_more_than_those_of_the_file() -> None:
    problem = contact_problem_of(form("height_range_um", height_unit_um=7), MEASURED)
    assert problem.pixel_size == pytest.approx((2e-6, 2e-6))
    assert np.ptp(problem.heights) == pytest.approx(7e-6)


@pytest.mark.parametrize(
    ("height_map", "given", "field", "code"),
    [
        (IMAGE, form("height_range_um"), "height_range_um", "missing"),
        (IMAGE, form("pixel_size_um"), "pixel_size_um", "missing"),
        (NUMBERS, form("height_range_um"), "height_unit_um", "missing"),
        (NUMBERS, form(height_unit_um=1), "height_range_um", "not-for-this-file"),
        (IMAGE, form(crop="60,0,5,5"), "crop", "out-of-range"),
        (IMAGE, form(resample_um=0.01), "resample_um", "out-of-range"),
    ],
)
def test_what_is_missing_or_does_not_fit(height_map: HeightMap, given: ProblemForm, field: str, code: str) -> None:
    with pytest.raises(InvalidFormError, match=field) as caught:
        contact_problem_of(given, height_map)
    assert [(error.field, error.code) for error in caught.value.errors] == [(field, code)]


def test_all_missing_units_are_told_at_once() -> None:
    with pytest.raises(InvalidFormError) as caught:
        contact_problem_of(form("pixel_size_um", "height_range_um"), IMAGE, NUMBERS)
    assert [error.field for error in caught.value.errors] == ["pixel_size_um", "height_range_um", "height_unit_um"]


def test_a_crop_is_that_part_of_the_map() -> None:
    problem = contact_problem_of(form(crop="10,20,30,40"), IMAGE)
    np.testing.assert_allclose(problem.heights, IMAGE.values[10:40, 20:60] * 50e-6, rtol=1e-12)


def test_two_rough_surfaces_face_each_other() -> None:
    """Pressed on its own mirror image turned inside out, a surface leaves no gap anywhere."""
    inverse = HeightMap(1 - IMAGE.values[:, ::-1], "PNG", bit_depth=16)
    problem = contact_problem_of(form(height_range_2_um=50), IMAGE, inverse)
    np.testing.assert_allclose(problem.heights, 50e-6, rtol=1e-12)


def test_the_second_surface_has_the_grid_of_the_first() -> None:
    with pytest.raises(InvalidFormError, match="32 x 64 pixels"):
        contact_problem_of(form(height_range_2_um=50), IMAGE, HeightMap(IMAGE.values[:32], "PNG", bit_depth=16))
    with pytest.raises(InvalidFormError, match="another size"):
        contact_problem_of(form(), IMAGE, MEASURED)
    with pytest.raises(InvalidFormError, match="height_range_2_um is missing"):
        contact_problem_of(form(), IMAGE, IMAGE)


def test_resampling_keeps_the_area_of_the_map() -> None:
    problem = contact_problem_of(form(resample_um=4.1), IMAGE)
    assert problem.shape == (31, 31)
    assert problem.nominal_area == pytest.approx((64 * 2e-6) ** 2)
