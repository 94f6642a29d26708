from dataclasses import replace

import numpy as np
import pytest

from solver import ContactProblem, Solution, random_midpoint_displacement, solve
from solver.closed_forms import HertzSphere
from solver.contact_statistics import (
    LEVELS,
    conductance_per_area,
    contact_spots,
    contact_statistics,
    corrected_area,
)
from tests.solver.conftest import PAPER_MODULUS

SPHERE = HertzSphere(radius=10e-3, load=5.0, effective_modulus=100e9)


def hertz(size: int, shift: float = 0.0) -> tuple[ContactProblem, Solution]:
    side = 3 * SPHERE.contact_radius
    centres = (np.arange(size) + 0.5) / size * side - side / 2
    y, x = np.meshgrid(centres, centres + shift * side / size, indexing="ij")
    problem = ContactProblem(-(y**2 + x**2) / (2 * SPHERE.radius), (side / size, side / size), 5.0, 100e9)
    return problem, solve(problem, tolerance=1e-8)


def test_hertz_pressure_gap_and_energy() -> None:
    """Mean pressure F / (pi a^2), two thirds of the peak; U = 2/5 F delta."""
    problem, solution = hertz(128)
    measured = contact_statistics(problem, solution)
    area = np.pi * SPHERE.contact_radius**2
    assert measured.pressure.mean == pytest.approx(5.0 / area, rel=0.02)
    assert measured.pressure.largest == pytest.approx(SPHERE.peak_pressure, rel=0.01)
    assert measured.pressure.rms == pytest.approx(SPHERE.peak_pressure / np.sqrt(2), rel=0.02)
    # Half of the area carries more than p0 sqrt(1 - 1/2).
    assert measured.pressure.quantiles[LEVELS.index(0.5)] == pytest.approx(SPHERE.peak_pressure / np.sqrt(2), rel=0.03)
    assert measured.elastic_energy == pytest.approx(0.4 * 5.0 * SPHERE.approach, rel=0.01)
    assert measured.spot_areas == pytest.approx([measured.pixel_area])
    assert measured.gap.quantiles[0] > 0
    assert measured.mean_gap == pytest.approx(measured.gap.mean * (1 - solution.contact_fraction), rel=1e-4)


def test_the_corrected_area_is_nearer_to_the_true_one() -> None:
    """Over Hertz contacts of 8 to 21 pixels radius it is off by less than half of what the pixel count is."""
    area = np.pi * SPHERE.contact_radius**2
    counted, corrected = [], []
    for size in (24, 32, 48, 64):
        for shift in (0.0, 0.25, 0.5):
            problem, solution = hertz(size, shift)
            measured = contact_statistics(problem, solution)
            counted.append(measured.pixel_area / area - 1)
            corrected.append(measured.corrected_area / area - 1)
    assert np.mean(counted) > 0.01
    assert abs(np.mean(corrected)) < 0.5 * np.mean(counted)


def spots_of(rows: list[str], boundary: str = "free") -> list[int]:
    mask = np.array([[character == "#" for character in row] for row in rows])
    return sorted(np.bincount(contact_spots(mask, boundary)[mask])[1:].tolist())  # type: ignore[arg-type]


def test_spots_share_edges_not_corners() -> None:
    assert spots_of(["##..", ".#..", "..#.", "...#"]) == [1, 1, 3]


def test_spots_of_a_periodic_surface_go_on_at_the_other_edge() -> None:
    rows = ["#..#", "....", ".#..", "#..#"]
    assert spots_of(rows) == [1, 1, 1, 1, 1]
    assert spots_of(rows, "periodic") == [1, 4]


def test_no_contact_has_no_spots() -> None:
    assert spots_of(["....", "...."]) == []
    assert spots_of(["....", "...."], "periodic") == []


def test_the_outline_of_a_periodic_surface_has_no_map_edges() -> None:
    mask = np.zeros((8, 8), dtype=np.bool_)
    mask[:, :3] = True
    share = (np.pi - 1 + np.log(2)) / 24
    assert corrected_area(mask, 2.0, "periodic") == pytest.approx(2 * (24 - 16 * share))
    assert corrected_area(mask, 2.0, "free") == pytest.approx(2 * (24 - 8 * share))
    assert corrected_area(np.ones((8, 8), dtype=np.bool_), 1.0, "periodic") == 64


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_flips_and_units_do_not_matter(boundary: str) -> None:
    heights = random_midpoint_displacement(32, seed=3) * 50e-6
    problem = ContactProblem(heights, (30e-6, 20e-6), 10.0, PAPER_MODULUS, boundary)  # type: ignore[arg-type]
    plain = contact_statistics(problem, solve(problem, tolerance=1e-9))
    flipped = replace(problem, heights=heights[::-1])
    mirrored = contact_statistics(flipped, solve(flipped, tolerance=1e-9))
    np.testing.assert_allclose(mirrored.spot_areas, plain.spot_areas)
    assert mirrored.elastic_energy == pytest.approx(plain.elastic_energy, rel=1e-6)
    assert mirrored.corrected_area == pytest.approx(plain.corrected_area)
    millimetres = replace(problem, heights=heights * 1e3, pixel_size=(30e-3, 20e-3), effective_modulus=PAPER_MODULUS * 1e-6)
    scaled = contact_statistics(millimetres, solve(millimetres, tolerance=1e-9))
    assert scaled.corrected_area == pytest.approx(plain.corrected_area * 1e6)
    assert scaled.gap.rms == pytest.approx(plain.gap.rms * 1e3, rel=1e-6)
    assert scaled.pressure.mean == pytest.approx(plain.pressure.mean * 1e-6, rel=1e-6)


def test_full_contact_has_no_gap() -> None:
    problem = ContactProblem(random_midpoint_displacement(32, seed=1) * 1e-6, (1e-3, 1e-3), 1e7, PAPER_MODULUS, "periodic")
    measured = contact_statistics(problem, solve(problem))
    assert measured.corrected_area == pytest.approx(problem.nominal_area)
    assert measured.gap.largest == 0
    assert len(measured.spot_areas) == 1


def test_conductance_per_area() -> None:
    problem = ContactProblem(np.zeros((10, 20)), (1e-3, 2e-3), 1.0, 1e9)
    assert conductance_per_area(2.0, problem) == pytest.approx(0.5 / 4e-4)
