"""GET /metrics, ids of requests, and headers of safety."""

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from prometheus_client.parser import text_string_to_metric_families

Predict = Callable[..., httpx.Response]


def read(client: httpx.Client) -> dict[tuple[str, ...], float]:
    """Values by name and labels."""
    families = text_string_to_metric_families(client.get("/metrics").text)
    return {(sample.name, *sorted(sample.labels.values())): sample.value for family in families for sample in family.samples}


def test_predictions_and_verifications_are_counted(
    predict: Predict, client: httpx.Client, finish: Callable[[str], dict[str, Any]]
) -> None:
    before = read(client)
    answer = predict(verify="true", load_n="44.5").json()
    dice = finish(answer["verification"]["url"])["comparison"]["dice"]
    after = read(client)

    def grown(*name: str) -> float:
        return after.get(name, 0) - before.get(name, 0)

    assert grown("asperity_predictions_total", answer["method"]) == 1
    assert grown("asperity_prediction_stage_seconds_count", "total") == 1
    assert grown("asperity_request_seconds_count", "/v1/predictions", "200", "POST") == 1
    assert grown("asperity_jobs_ended_total", "finished") >= 1
    assert grown("asperity_verifications_total", answer["model"]) >= 1
    assert grown("asperity_dice_error_total", answer["model"]) >= 1 - dice - 1e-9
    assert after["asperity_queue_up",] == 1
    assert after["asperity_workers",] == 1
    assert after["asperity_jobs_waiting",] >= 0


def test_a_request_keeps_its_id(client: httpx.Client) -> None:
    assert client.get("/healthz", headers={"X-Request-ID": "my-own.id"}).headers["x-request-id"] == "my-own.id"
    ids = {client.get("/healthz").headers["x-request-id"] for _ in range(3)}
    assert len(ids) == 3
    assert client.get("/healthz", headers={"X-Request-ID": "two\twords"}).headers["x-request-id"] != "two\twords"
    assert client.get("/nothing", headers={"X-Request-ID": "lost"}).headers["x-request-id"] == "lost"


@pytest.mark.parametrize("path", ["/", "/healthz", "/web/main.js", "/nothing", "/v1/jobs"])
def test_every_answer_has_headers_of_safety(client: httpx.Client, path: str) -> None:
    headers = client.get(path).headers
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["x-frame-options"] == "DENY"
    assert headers["referrer-policy"] == "no-referrer"
