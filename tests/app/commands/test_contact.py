"""`asperity predict` and `asperity solve`."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.app.conftest import UNITS, run
from tests.app.files import surface_png

OPTIONS = [word for name, value in UNITS.items() for word in (f"--{name.replace('_', '-')}", value)]


@pytest.fixture
def surface(tmp_path: Path) -> Path:
    path = tmp_path / "surface.png"
    path.write_bytes(surface_png())
    return path


@pytest.mark.parametrize("command", ["predict", "solve"])
def test_numbers_and_mask_agree(command: str, surface: Path, tmp_path: Path) -> None:
    mask_file = tmp_path / "mask.png"
    done = run(command, surface, *OPTIONS, "--resistivity-ohm-m", "1e-8", "--json", "--mask", mask_file)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    mask = np.asarray(Image.open(mask_file))
    assert mask.dtype == np.bool_
    assert answer["contact_fraction"] == pytest.approx(mask.mean())
    assert answer["contact_area_mm2"] == pytest.approx(mask.mean())
    assert answer["contact_resistance_ohm"] > 0


@pytest.mark.parametrize("command", ["predict", "solve"])
def test_a_table_is_printed(command: str, surface: Path) -> None:
    done = run(command, surface, *OPTIONS)
    assert done.returncode == 0, done.stderr
    assert "fraction" in done.stdout


def test_an_accuracy_is_asked_for(surface: Path) -> None:
    done = run("predict", surface, *OPTIONS, "--accuracy", "exact", "--json")
    assert json.loads(done.stdout)["method"] == "solver"
    refused = run("predict", surface, *OPTIONS, "--accuracy", "perfect")
    assert refused.returncode == 2
    assert "balanced" in refused.stderr


def test_the_solve_adds_spots_stiffness_and_energy_and_caps_the_pressure(surface: Path) -> None:
    done = run("solve", surface, *OPTIONS, "--hardness-gpa", "0.5", "--method", "multilevel", "--json")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["highest_pressure_gpa"] <= 0.5 * (1 + 1e-9)
    assert answer["contact_spots"] >= 1
    assert answer["contact_stiffness_n_per_m"] > 0
    assert answer["elastic_energy_j"] > 0
    assert 0 < answer["corrected_contact_area_mm2"] < answer["contact_area_mm2"]


def test_the_solve_shows_its_progress_and_status(surface: Path) -> None:
    done = run("solve", surface, *OPTIONS)
    assert "residual=" in done.stderr
    assert "Converged" in done.stdout


def test_an_unconverged_solve_fails(surface: Path) -> None:
    done = run("solve", surface, *OPTIONS, "--tolerance", "1e-17", "--json")
    assert done.returncode == 1
    assert json.loads(done.stdout)["converged"] is False


@pytest.mark.parametrize("command", ["predict", "solve"])
def test_bad_input_is_told_in_one_line(command: str, surface: Path) -> None:
    done = run(command, surface, "--load-n", "-1", "--pixel-size-um", "1")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "--load-n is -1; it must be positive" in done.stderr
    assert "--effective-modulus-gpa is missing" in done.stderr


def test_a_file_that_is_no_height_map_is_bad_input(tmp_path: Path) -> None:
    text = tmp_path / "heights.txt"
    text.write_text("dear diary")
    done = run("predict", text, *OPTIONS)
    assert done.returncode == 2
    assert "no format that is read" in done.stderr


def test_a_missing_file_is_bad_input(tmp_path: Path) -> None:
    assert run("predict", tmp_path / "none.png", *OPTIONS).returncode == 2


def test_every_field_of_the_form_is_an_option_with_its_unit() -> None:
    text = run("predict", "--help").stdout
    assert "--youngs-modulus-1-gpa" in text
    assert "in N" in text
    assert "micrometres" in text
