"""The fields of a contact problem: units, either-or choices, and a message of its own for every mistake."""

import pytest

from app.errors import InvalidFormError
from app.forms import ProblemForm

GOOD = {"load_n": 20, "pixel_size_um": 2, "height_range_um": 50, "effective_modulus_gpa": 6.843}
STEEL_ON_COPPER = {
    "youngs_modulus_1_gpa": 200,
    "poissons_ratio_1": 0.3,
    "youngs_modulus_2_gpa": 110,
    "poissons_ratio_2": 0.34,
}


def without(*names: str, **more: object) -> dict[str, object]:
    return {name: value for name, value in GOOD.items() if name not in names} | more


@pytest.mark.parametrize(
    ("values", "field", "code", "words"),
    [
        (without("load_n"), "load_n", "missing", "total normal force .* in N"),
        (without("effective_modulus_gpa"), "effective_modulus_gpa", "missing", "in GPa, or youngs_modulus_1_gpa"),
        (without("pixel_size_um", pixel_size_x_um=1), "pixel_size_um", "missing", "pixel_size_y_um missing"),
        (GOOD | {"pixel_size_x_um": 1}, "pixel_size_um", "ambiguous", "one or the other"),
        (GOOD | {"poissons_ratio_2": 0.3}, "effective_modulus_gpa", "ambiguous", "one or the other"),
        (GOOD | {"load_n": 0}, "load_n", "not-positive", "load_n is 0; it must be positive"),
        (GOOD | {"load_n": "-3"}, "load_n", "not-positive", "load_n is -3; it must be positive"),
        (GOOD | {"load_n": "nan"}, "load_n", "not-finite", "load_n is nan; it must be a finite number"),
        (GOOD | {"height_range_um": "inf"}, "height_range_um", "not-finite", "must be a finite number"),
        (GOOD | {"pixel_size_um": "2 um"}, "pixel_size_um", "not-a-number", "'2 um'; it must be a number"),
        (GOOD | {"resistivity_ohm_m": -1}, "resistivity_ohm_m", "not-positive", "in ohm m"),
        (GOOD | {"boundary": "open"}, "boundary", "invalid", "must be 'free' or 'periodic'"),
        (GOOD | {"crop": "1,2,3"}, "crop", "invalid", "first row, first column, rows, columns"),
        (GOOD | {"crop": "0,0,0,5"}, "crop", "invalid", "first row, first column, rows, columns"),
        (GOOD | {"crop": "-1,0,5,5"}, "crop", "invalid", "first row, first column, rows, columns"),
        (GOOD | {"detrend": "cubic"}, "detrend", "invalid", "'none', 'mean', 'plane' or 'curvature'"),
        (
            without("effective_modulus_gpa", **STEEL_ON_COPPER | {"poissons_ratio_1": 0.6}),
            "poissons_ratio_1",
            "out-of-range",
            r"\(-1, 0.5\]",
        ),
        (
            without("effective_modulus_gpa", **STEEL_ON_COPPER | {"youngs_modulus_1_gpa": "nan"}),
            "youngs_modulus_1_gpa",
            "not-positive",
            "is nan",
        ),
    ],
)
def test_refusals(values: dict[str, object], field: str, code: str, words: str) -> None:
    with pytest.raises(InvalidFormError, match=words) as caught:
        ProblemForm.parse(values)
    assert [(error.field, error.code) for error in caught.value.errors] == [(field, code)]


def test_all_mistakes_are_told_at_once() -> None:
    with pytest.raises(InvalidFormError) as caught:
        ProblemForm.parse({"load_n": "much"})
    assert {error.field for error in caught.value.errors} == {"load_n", "effective_modulus_gpa"}
