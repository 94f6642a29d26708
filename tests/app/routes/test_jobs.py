"""/v1/jobs: verifications by a real worker."""

import io
import json
import time
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from model.metrics import compare
from tests.app.files import surface_png

Predict = Callable[..., httpx.Response]
Finish = Callable[[str], dict[str, Any]]


def mask(client: httpx.Client, url: str) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(client.get(url).content)))


def test_a_verification_finishes_with_its_comparison(predict: Predict, finish: Finish, client: httpx.Client) -> None:
    prediction = predict(verify="true", resistivity_ohm_m="1.7e-8").json()
    assert prediction["verification"]["url"] == f"/v1/jobs/{prediction['verification']['job_id']}"
    job = finish(prediction["verification"]["url"])
    assert job["status"] == "finished"
    assert job["error"] is None
    result, comparison = job["result"], job["comparison"]
    assert result["converged"]
    reference, predicted = mask(client, result["mask_url"]), mask(client, prediction["mask_url"])
    assert result["contact_fraction"] == pytest.approx(reference.mean())
    expected = compare(reference, predicted)
    assert comparison["dice"] == pytest.approx(expected.dice)
    assert comparison["area_error"] == pytest.approx(expected.area_error)
    assert comparison["resistance_error"] == pytest.approx(
        prediction["contact_resistance_ohm"] / result["contact_resistance_ohm"] - 1
    )
    assert comparison["dice"] > 0.8


def test_verification_is_the_default(predict: Predict) -> None:
    assert predict(verify=None).json()["verification"] is not None


def test_a_running_verification_can_be_canceled(predict: Predict, finish: Finish, client: httpx.Client) -> None:
    url = predict(surface_png(1024), pixel_size_um="1", verify="true").json()["verification"]["url"]
    assert client.delete(url).status_code == 200
    job = finish(url)
    assert job["status"] == "canceled"
    assert job["comparison"] is None
    assert client.get(f"{url}/mask.png").status_code == 404


@pytest.mark.parametrize(
    ("method", "path"), [("GET", ""), ("DELETE", ""), ("GET", "/events"), ("GET", "/mask.png"), ("GET", "/pressure.npy")]
)
def test_unknown_jobs_are_not_found(client: httpx.Client, method: str, path: str) -> None:
    response = client.request(method, f"/v1/jobs/nonsense{path}")
    assert response.status_code == 404
    assert response.json()["type"] == "/problems/job-not-found"


def test_a_job_is_followed_by_events_to_its_end(predict: Predict, client: httpx.Client) -> None:
    link = predict(surface_png(512), pixel_size_um="2", verify="true").json()["verification"]
    with client.stream("GET", link["events_url"]) as response:
        assert response.headers["content-type"].startswith("text/event-stream")
        lines = [line for line in response.iter_lines() if line.startswith(("event:", "data:"))]
    names = [line.removeprefix("event: ") for line in lines[::2]]
    jobs = [json.loads(line.removeprefix("data: ")) for line in lines[1::2]]
    assert names == [job["status"] for job in jobs]
    order = ["queued", "started", "finished"]
    assert names == sorted(names, key=order.index)
    assert names[-1] == "finished"
    assert jobs[-1]["comparison"]["dice"] > 0.8
    assert any(job["progress"] for job in jobs)


def test_the_time_left_is_estimated(predict: Predict, client: httpx.Client) -> None:
    link = predict(surface_png(1024), pixel_size_um="1", verify="true").json()["verification"]
    with client.stream("GET", link["events_url"]) as response:
        jobs = (json.loads(line.removeprefix("data: ")) for line in response.iter_lines() if line.startswith("data:"))
        left = next(job["progress"]["seconds_left"] for job in jobs if (job["progress"] or {}).get("seconds_left"))
    client.delete(link["url"])
    assert 0 < left < 3600


def test_events_of_an_ended_job_are_its_end(predict: Predict, finish: Finish, client: httpx.Client) -> None:
    link = predict(verify="true").json()["verification"]
    finish(link["url"])
    assert client.get(link["events_url"]).text.count("event: finished") == 1


def test_the_queue_position_is_told(predict: Predict, finish: Finish, client: httpx.Client) -> None:
    slow = predict(surface_png(1024), pixel_size_um="1", verify="true").json()["verification"]["url"]
    while client.get(slow).json()["status"] == "queued":
        time.sleep(0.05)
    waiting = [predict(verify="true", load_n=load).json()["verification"]["url"] for load in ("21", "22", "23")]
    positions = [client.get(url).json()["queue_position"] for url in waiting]
    assert positions == [0, 1, 2]
    client.delete(slow)
    assert finish(waiting[-1])["queue_position"] is None


def test_jobs_are_listed_newest_first_by_pages(predict: Predict, client: httpx.Client) -> None:
    ids = [predict(verify="true", load_n=load).json()["verification"]["job_id"] for load in ("11", "12", "13")]
    first = client.get("/v1/jobs", params={"limit": 2}).json()
    assert [job["id"] for job in first["items"]] == ids[:0:-1]
    second = client.get(first["next"]).json()
    assert second["items"][0]["id"] == ids[0]
    assert client.get("/v1/jobs", params={"before": "0" * 32}).status_code == 404
    assert client.get("/v1/jobs", params={"limit": 0}).status_code == 422
