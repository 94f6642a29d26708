"""POST /v1/sweeps: one surface under many loads."""

import csv
import io
import json
from collections.abc import Callable

import httpx
import pytest

from model.methods import TARGETS
from solver import ContactProblem, solve
from tests.app.conftest import UNITS
from tests.app.files import surface_codes, surface_png

Sweep = Callable[..., httpx.Response]
HEADERS = {"accept": "application/json"}


@pytest.fixture(scope="module")
def sweep(client: httpx.Client) -> Sweep:
    def post(accept: str = "application/json", **fields: str) -> httpx.Response:
        data = {name: value for name, value in UNITS.items() if name != "load_n"} | fields
        return client.post("/v1/sweeps", data=data, files={"surface": surface_png()}, headers={"accept": accept})

    return post


def test_area_grows_and_resistance_falls_with_load(sweep: Sweep) -> None:
    response = sweep(load_from_n="1", load_to_n="100", load_count="9", resistivity_ohm_m="1e-7")
    assert response.status_code == 200, response.text
    answer = response.json()
    points = answer["points"]
    assert [point["load_n"] for point in points] == pytest.approx([10 ** (n / 4) for n in range(9)])
    for name, sign in (("contact_area_mm2", 1), ("contact_stiffness_n_per_m", 1), ("contact_resistance_ohm", -1)):
        values = [sign * point[name] for point in points]
        assert values == sorted(values)
    assert all(point["contact_spots"] >= 1 for point in points)
    assert all(point["error"] is None for point in points)
    assert answer["surface"]["rows"] == 64
    assert answer["model"].startswith("contactnet")


def test_every_point_is_as_accurate_as_asked_for(sweep: Sweep) -> None:
    points = sweep(loads_n="3,30", accuracy="balanced").json()["points"]
    for point in points:
        problem = ContactProblem(surface_codes() / 65535 * 50e-6, (15.625e-6,) * 2, point["load_n"], 6.843e9)
        truth = solve(problem).contact_fraction
        assert point["contact_fraction"] == pytest.approx(truth, rel=3 * TARGETS["balanced"])
        assert point["contact_area_error"] <= TARGETS["balanced"]


def test_the_same_as_csv(sweep: Sweep) -> None:
    as_json = sweep(loads_n="5,20,10").json()["points"]
    response = sweep("text/csv", loads_n="5,20,10")
    assert response.headers["content-type"].startswith("text/csv")
    rows = list(csv.DictReader(io.StringIO(response.text)))
    assert [float(row["load_n"]) for row in rows] == [5, 20, 10]
    for row, point in zip(rows, as_json, strict=True):
        assert float(row["contact_area_mm2"]) == point["contact_area_mm2"]


def test_points_come_one_by_one(client: httpx.Client) -> None:
    data = {name: value for name, value in UNITS.items() if name != "load_n"}
    data |= {"load_from_n": "1", "load_to_n": "100", "load_count": "20", "accuracy": "exact"}
    with client.stream("POST", "/v1/sweeps", data=data, files={"surface": surface_png(256)}, headers=HEADERS) as response:
        parts = list(response.iter_text())
    assert len(parts) > 10
    assert len(json.loads("".join(parts))["points"]) == 20


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({}, "loads_n"),
        ({"loads_n": "1,-2"}, "loads_n"),
        ({"loads_n": "1,two"}, "loads_n"),
        ({"loads_n": ",".join(["1"] * 201)}, "loads_n"),
        ({"load_from_n": "1", "load_to_n": "9"}, "loads_n"),
        ({"load_from_n": "1", "load_to_n": "9", "load_count": "0"}, "load_count"),
        ({"loads_n": "1", "load_from_n": "1"}, "loads_n"),
        ({"loads_n": "1", "pixel_size_um": "-1"}, "pixel_size_um"),
    ],
)
def test_loads_that_cannot_be(sweep: Sweep, fields: dict[str, str], field: str) -> None:
    response = sweep(**fields)
    assert response.status_code == 422
    problem = response.json()
    assert [error["field"] for error in problem["errors"]] == [field]
