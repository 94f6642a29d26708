"""What is said of a height map before the answer."""

import re

import numpy as np
import pytest
from numpy.typing import NDArray

from app.contact_problem import contact_problem
from app.forms import ProblemForm
from app.height_map import HeightMap
from app.surface import read_surface, surface_warnings
from tests.app.files import surface_codes

SIDE = 64
Y, X = np.mgrid[:SIDE, :SIDE]
WAVES = sum(
    np.sin(2 * np.pi * (a * Y + b * X) / SIDE + phase)
    for a, b, phase in ((3, 1, 0.3), (-2, 4, 1.1), (5, 2, 2.5), (1, -6, 4.0))
)
"""A map that repeats."""


def sixteen_bits(heights: NDArray[np.float64]) -> NDArray[np.uint16]:
    return np.rint((heights - heights.min()) / np.ptp(heights) * 65535).astype(np.uint16)


def form(**values: object) -> ProblemForm:
    units = {"load_n": 20, "pixel_size_um": 10, "height_range_um": 50, "effective_modulus_gpa": 7}
    return ProblemForm.parse(units | values)


def warnings(codes: NDArray[np.uint16], bit_depth: int = 16, **values: object) -> list[str]:
    height_map = HeightMap(codes / (2**bit_depth - 1), "PNG", bit_depth)
    given = form(**values)
    return surface_warnings(height_map, given, contact_problem(given, 20.0, height_map))


def test_what_was_read() -> None:
    height_map = HeightMap(sixteen_bits(WAVES)[:, :48] / 65535, "PNG", 16)
    surface = read_surface(height_map, contact_problem(form(), 20.0, height_map))
    assert (surface.rows, surface.columns, surface.file_format, surface.bit_depth) == (64, 48, "PNG", 16)
    assert surface.missing_pixels == 0
    assert surface.height_range_um == pytest.approx(50, rel=1e-3)
    assert surface.rms_height_um == pytest.approx(50 * WAVES.std() / np.ptp(WAVES), rel=0.1)


def test_a_sound_map_has_no_warnings() -> None:
    assert warnings(sixteen_bits(WAVES)) == []
    assert warnings(sixteen_bits(WAVES), boundary="periodic") == []


@pytest.mark.parametrize(
    ("codes", "values", "words"),
    [
        pytest.param(sixteen_bits(WAVES) // 257 * 257, {}, "only .* distinct heights", id="from-8-bits"),
        pytest.param(sixteen_bits(np.minimum(WAVES, 0.5)), {}, "at the highest level", id="clipped-above"),
        pytest.param(sixteen_bits(np.maximum(WAVES, -0.5)), {}, "at the lowest level", id="clipped-below"),
        pytest.param(sixteen_bits(WAVES + 0.3 * Y), {}, "tilt", id="tilted"),
        pytest.param(sixteen_bits(WAVES), {"pixel_size_um": 0.01}, "rms slope", id="too-steep"),
        pytest.param(sixteen_bits(WAVES), {"height_range_um": 0.01}, "rms slope", id="too-flat"),
        pytest.param(surface_codes(), {"boundary": "periodic"}, "Opposite edges", id="does-not-repeat"),
    ],
)
def test_warnings(codes: NDArray[np.uint16], values: dict[str, object], words: str) -> None:
    found = warnings(codes, **values)
    assert len(found) == 1
    assert re.search(words, found[0])


def test_eight_bits_are_told() -> None:
    assert "quantised" in warnings(sixteen_bits(WAVES) // 257, bit_depth=8)[0]


def numbers() -> HeightMap:
    values = WAVES * 1e-6
    values[3, 4] = np.nan
    return HeightMap(values, "X3P", height_unit=1.0, pixel_size=(1e-5, 1e-5))


def test_missing_pixels_are_counted() -> None:
    given = ProblemForm.parse({"load_n": 20, "effective_modulus_gpa": 7})
    problem = contact_problem(given, 20.0, numbers())
    assert read_surface(numbers(), problem).missing_pixels == 1
    (warning,) = surface_warnings(numbers(), given, problem)
    assert warning.startswith("1 pixels")


@pytest.mark.parametrize(
    ("other", "words"), [({"pixel_size_um": 20}, "10 x 10 um"), ({"height_unit_um": 1e3}, "unit of height is 1 m")]
)
def test_units_that_contradict_the_file_are_told(other: dict[str, object], words: str) -> None:
    given = ProblemForm.parse({"load_n": 20, "effective_modulus_gpa": 7} | other)
    found = surface_warnings(numbers(), given, contact_problem(given, 20.0, numbers()))
    assert any(words in warning and "the request" in warning for warning in found)
