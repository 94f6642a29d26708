"""GET /v1/models."""

import httpx

from model import Surrogate


def test_the_model_says_what_it_is(client: httpx.Client) -> None:
    (model,) = client.get("/v1/models").json()
    assert model["version"] == Surrogate.load().version
    assert model["version"] == f"{model['name']}-{model['sha256'][:8]}"
    assert all(lowest < highest for lowest, highest in model["domain"].values())
    assert model["measured_error"]["128 x 128"]["dice"] > 0.9
