"""/v1/jobs: verifications by a real worker."""

import io
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


@pytest.mark.parametrize("method", ["GET", "DELETE"])
def test_unknown_jobs_are_not_found(client: httpx.Client, method: str) -> None:
    response = client.request(method, "/v1/jobs/nonsense")
    assert response.status_code == 404
    assert response.json()["type"] == "/problems/job-not-found"
