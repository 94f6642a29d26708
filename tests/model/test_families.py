import numpy as np
import pytest

from model.families import CODES, LOG_LOAD_RANGE, Family, Units, simple_problems, varied_problems
from model.features import log_load
from solver import random_midpoint_displacement
from solver.roughness import roughness


def test_midpoint_problems_are_the_papers() -> None:
    (drawn,) = simple_problems("midpoint", 64, range(7, 8), (0.5, 0.5), (30.0, 30.0), Units())
    problem = drawn.problem
    expected = np.rint(random_midpoint_displacement(64, 0.5, 7) * CODES)
    np.testing.assert_array_equal(drawn.codes, expected)
    assert problem.heights.max() == pytest.approx(50e-6)
    assert problem.load == pytest.approx(30.0)
    assert (problem.effective_modulus, problem.boundary) == (6.843e9, "free")
    assert problem.pixel_size == (1e-3 / 64, 1e-3 / 64)


@pytest.mark.parametrize("family", ["roll-off", "anisotropic", "skewed"])
def test_spectral_problems_are_of_their_kind(family: Family) -> None:
    for drawn in simple_problems(family, 128, range(4), (0.8, 0.8), (10.0, 50.0), Units()):
        found = roughness(drawn.problem.heights, drawn.problem.pixel_size)
        along_x, along_y = (np.diff(drawn.problem.heights, axis=axis).std() for axis in (1, 0))
        power = np.abs(np.fft.rfft2(drawn.problem.heights - drawn.problem.heights.mean())) ** 2
        assert (found.rsk < -1) == (family == "skewed")
        assert (max(along_x, along_y) > 1.5 * min(along_x, along_y)) == (family == "anisotropic")
        assert (power[0:3, 0:3].sum() < 0.2 * power.sum()) == (family == "roll-off")


def test_a_draw_of_varied_problems_shares_its_grid_and_differs_in_all_else() -> None:
    drawn = varied_problems(32, range(100, 140), Units())
    assert len({(one.problem.boundary, one.problem.pixel_size) for one in drawn}) == 1
    loads = [log_load(one.problem) for one in drawn]
    assert LOG_LOAD_RANGE[0] - 1e-6 <= min(loads) < -3
    assert -1 < max(loads) <= LOG_LOAD_RANGE[1] + 1e-6
    slopes = [one.problem.rms_slope for one in drawn]
    assert max(slopes) > 5 * min(slopes)
    assert all(one.codes.min() == 0 and one.codes.max() == CODES for one in drawn)


def test_a_problem_depends_on_its_seed_and_on_the_first_of_its_draw_alone() -> None:
    whole, part = varied_problems(32, range(100, 116), Units()), varied_problems(32, range(100, 103), Units())
    for one, other in zip(part, whole, strict=False):
        np.testing.assert_array_equal(one.codes, other.codes)
        assert one.problem.load == other.problem.load


def test_units_give_a_surface_its_size() -> None:
    (one,) = varied_problems(32, range(5, 6), Units())
    (other,) = varied_problems(32, range(5, 6), Units(side_mm=2.0, height_range_um=10.0, effective_modulus_gpa=100.0))
    np.testing.assert_array_equal(one.codes, other.codes)
    assert other.problem.pixel_size[1] == pytest.approx(2 * one.problem.pixel_size[1])
    assert log_load(other.problem) == pytest.approx(log_load(one.problem))
