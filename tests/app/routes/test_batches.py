"""POST /v1/batches: many height maps in one archive."""

import json

import httpx

from tests.app.conftest import UNITS
from tests.app.files import surface_png
from tests.app.test_archive import zipped


def test_every_file_gets_its_prediction_or_its_problem(client: httpx.Client) -> None:
    files = {"one.png": surface_png(seed=51), "notes.txt": b"dear diary", "two.png": surface_png(seed=52)}
    response = client.post("/v1/batches", data=UNITS, files={"archive": zipped(files)})
    assert response.status_code == 200, response.text
    items = [json.loads(line) for line in response.text.splitlines()]
    assert [item["file"] for item in items] == list(files)
    assert items[1]["prediction"] is None
    assert items[1]["problem"]["type"] == "/problems/unknown-format"
    for item, seed in ((items[0], 51), (items[2], 52)):
        assert item["problem"] is None
        alone = client.post("/v1/predictions", data=UNITS | {"verify": "false"}, files={"surface": surface_png(seed=seed)})
        assert item["prediction"] == alone.json()
        assert item["prediction"]["verification"] is None


def test_a_damaged_file_does_not_stop_the_others(client: httpx.Client) -> None:
    data = bytearray(zipped({"one.png": surface_png(seed=53), "two.png": surface_png(seed=54)}))
    data[data.index(b"one.png") + 2000] ^= 255
    response = client.post("/v1/batches", data=UNITS, files={"archive": bytes(data)})
    one, two = map(json.loads, response.text.splitlines())
    assert one["problem"]["type"] == "/problems/invalid-archive"
    assert two["prediction"]["contact_fraction"] > 0


def test_what_is_no_archive(client: httpx.Client) -> None:
    response = client.post("/v1/batches", data=UNITS, files={"archive": surface_png()})
    assert response.status_code == 422
    assert response.json()["errors"][0]["field"] == "archive"


def test_a_field_of_another_form_is_not_suggested(client: httpx.Client) -> None:
    response = client.post("/v1/batches", data=UNITS, files={"surface": surface_png()})
    (error,) = [one for one in response.json()["errors"] if one["code"] == "unknown"]
    assert error["field"] == "surface"
    assert "archive" in error["detail"]
    assert "did you mean surface" not in error["detail"]
