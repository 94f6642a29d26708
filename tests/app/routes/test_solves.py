"""POST /v1/solves: reference solves without a prediction."""

import io
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from solver import ContactProblem, solve
from tests.app.conftest import UNITS
from tests.app.files import surface_codes, surface_png

Finish = Callable[[str], dict[str, Any]]


def post(client: httpx.Client, surface: bytes = surface_png(), **fields: str) -> httpx.Response:
    return client.post("/v1/solves", data=UNITS | fields, files={"surface": surface})


def test_a_solve_ends_in_the_solution(client: httpx.Client, finish: Finish) -> None:
    response = post(client, resistivity_ohm_m="1e-7", outputs="pressure,gap,statistics,resistances")
    assert response.status_code == 202, response.text
    answer = response.json()
    assert answer["surface"]["rows"] == 64
    job = finish(answer["job"]["url"])
    assert (job["status"], job["kind"], job["comparison"]) == ("finished", "solve", None)
    result = job["result"]
    assert result["converged"]
    assert result["resistances"]["boyer_ohm"] == pytest.approx(result["contact_resistance_ohm"])
    assert result["statistics"]["contact_spots"] >= 1
    url = answer["job"]["url"]
    pressure, gap = (np.load(io.BytesIO(client.get(f"{url}/{name}.npy").content)) for name in ("pressure", "gap"))
    mask = np.asarray(Image.open(io.BytesIO(client.get(result["mask_url"]).content)))
    truth = solve(ContactProblem(surface_codes() / 65535 * 50e-6, (15.625e-6,) * 2, 20.0, 6.843e9))
    np.testing.assert_array_equal(mask, truth.contact_mask)
    np.testing.assert_array_equal(pressure > 0, mask)
    assert np.abs(pressure - truth.pressure).max() < 1e-3 * truth.pressure.max()
    assert np.abs(gap[mask]).max() < 1e-5 * 50e-6


def test_fields_that_were_not_asked_for_are_not_there(client: httpx.Client, finish: Finish) -> None:
    url = post(client).json()["job"]["url"]
    job = finish(url)
    assert job["result"]["statistics"] is job["result"]["resistances"] is None
    missing = client.get(f"{url}/pressure.npy")
    assert missing.status_code == 404
    assert "outputs=pressure" in missing.json()["detail"]


def test_waiting_for_the_end_is_a_preference(client: httpx.Client) -> None:
    request = {"data": UNITS | {"load_n": "19"}, "files": {"surface": surface_png()}}
    answer = client.post("/v1/solves", headers={"prefer": "respond-async, Wait=50"}, **request)  # type: ignore[arg-type]
    assert answer.headers["preference-applied"] == "wait=50"
    patient = answer.json()["job"]["state"]
    assert patient["status"] == "finished"
    assert patient["result"]["converged"]
    at_once = client.post("/v1/solves", **request)  # type: ignore[arg-type]
    assert at_once.json()["job"]["state"] is None
    assert "preference-applied" not in at_once.headers
    big = {"data": UNITS | {"pixel_size_um": "1"}, "files": {"surface": surface_png(1024)}}
    hasty = client.post("/v1/solves", headers={"prefer": "wait=1"}, **big).json()["job"]  # type: ignore[arg-type]
    assert hasty["state"]["status"] in ("queued", "started")
    client.delete(hasty["url"])


def test_a_hardness_caps_the_pressure(client: httpx.Client, finish: Finish) -> None:
    answer = post(client, hardness_gpa="0.5", outputs="statistics").json()
    job = finish(answer["job"]["url"])
    assert job["result"]["statistics"]["highest_pressure_gpa"] <= 0.5 * (1 + 1e-9)


@pytest.mark.parametrize(
    ("fields", "field"),
    [({"outputs": "mask"}, "outputs"), ({"outputs": "resistances"}, "outputs"), ({"load_n": "0"}, "load_n")],
)
def test_refusals(client: httpx.Client, fields: dict[str, str], field: str) -> None:
    response = post(client, **fields)
    assert response.status_code == 422
    assert [error["field"] for error in response.json()["errors"]] == [field]


def test_an_idempotency_key_queues_once(client: httpx.Client) -> None:
    def post_with_key(load: str) -> httpx.Response:
        files, headers = {"surface": surface_png()}, {"idempotency-key": "solve me"}
        return client.post("/v1/solves", data=UNITS | {"load_n": load}, files=files, headers=headers)

    assert post_with_key("5").json() == post_with_key("5").json()
    assert post_with_key("6").status_code == 422
    assert post(client, load_n="5").json()["job"] != post(client, load_n="5").json()["job"]
