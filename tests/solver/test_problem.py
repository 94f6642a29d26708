import numpy as np
import pytest

from solver import ContactProblem, effective_modulus
from solver.errors import (
    AsperityError,
    InvalidHeightsError,
    InvalidLoadError,
    InvalidMaterialError,
    InvalidPixelSizeError,
    InvalidProblemError,
)

GOOD = {"heights": np.eye(8), "pixel_size": (1e-6, 1e-6), "load": 1.0, "effective_modulus": 1e9, "boundary": "free"}
WITH_NAN = np.eye(8)
WITH_NAN[3, 5] = np.nan


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"heights": np.zeros(16)}, InvalidHeightsError, "(rows, columns)"),
        ({"heights": np.zeros((3, 8))}, InvalidHeightsError, "3 x 8"),
        ({"heights": np.zeros((4, 8193))}, InvalidHeightsError, "4 to 8192"),
        ({"heights": WITH_NAN}, InvalidHeightsError, "row 3, column 5"),
        ({"pixel_size": (1e-6, 0.0)}, InvalidPixelSizeError, "(1e-06, 0) m"),
        ({"pixel_size": 1e-6}, InvalidPixelSizeError, "pair"),
        ({"pixel_size": (1.0, 1e-9)}, InvalidPixelSizeError, "factor of 1000"),
        ({"pixel_size": (1e-170, 1e-170)}, InvalidPixelSizeError, "area"),
        ({"heights": np.eye(8) * 1e200}, InvalidHeightsError, "too large"),
        ({"load": 0.0}, InvalidLoadError, "0 N"),
        ({"load": -2.5}, InvalidLoadError, "-2.5 N"),
        ({"load": np.inf}, InvalidLoadError, "inf N"),
        ({"load": np.nan}, InvalidLoadError, "nan N"),
        ({"load": 1e300}, InvalidLoadError, "1e+300 N"),
        ({"load": 1e-60}, InvalidLoadError, "1e-60 N"),
        ({"effective_modulus": 0.0}, InvalidMaterialError, "0 Pa"),
        ({"boundary": "fixed"}, InvalidProblemError, "'fixed'"),
    ],
)
def test_bad_input_is_refused_with_the_value_and_what_is_allowed(
    change: dict[str, object], error: type[AsperityError], words: str
) -> None:
    with pytest.raises(error) as raised:
        ContactProblem(**(GOOD | change))  # type: ignore[arg-type]
    assert words in str(raised.value)
    assert raised.value.http_status == 422


def test_the_problem_keeps_its_own_heights() -> None:
    heights = np.eye(8)
    problem = ContactProblem(**(GOOD | {"heights": heights}))  # type: ignore[arg-type]
    heights[0, 0] = 99
    assert problem.heights[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        problem.heights[0, 0] = 5


def test_effective_modulus_of_two_steel_bodies() -> None:
    assert effective_modulus(210e9, 0.3, 210e9, 0.3) == pytest.approx(210e9 / (2 * 0.91))
    assert effective_modulus(210e9, 0.3, np.inf, 0.3) == pytest.approx(210e9 / 0.91)


@pytest.mark.parametrize(
    ("bodies", "words"),
    [((0, 0.3, 1e9, 0.3), "first"), ((1e9, 0.3, 1e9, 0.6), "second"), ((np.inf, 0.3, np.inf, 0.3), "rigid")],
)
def test_impossible_materials_are_refused(bodies: tuple[float, float, float, float], words: str) -> None:
    with pytest.raises(InvalidMaterialError, match=words):
        effective_modulus(*bodies)


def test_statistics_of_a_tilted_plane() -> None:
    rows, columns = np.mgrid[:10, :20]
    problem = ContactProblem(rows * 3e-6 + columns * 8e-6, (1e-6, 2e-6), 1.0, 1e9)
    assert problem.rms_slope == pytest.approx(5.0)
    assert problem.nominal_area == pytest.approx(400e-12)
    assert problem.nominal_pressure == pytest.approx(2.5e9)
