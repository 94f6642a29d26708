"""Every error is a problem document."""

import httpx
import pytest
from fastapi import FastAPI

from app.problems import add_problem_handlers


@pytest.mark.parametrize(
    ("method", "path", "status", "code"),
    [
        ("GET", "/nothing/here", 404, "not-found"),
        ("GET", "/web/nothing.js", 404, "not-found"),
        ("PUT", "/v1/predictions", 405, "method-not-allowed"),
        ("POST", "/", 405, "method-not-allowed"),
    ],
)
def test_unknown_routes(client: httpx.Client, method: str, path: str, status: int, code: str) -> None:
    response = client.request(method, path)
    assert response.headers["content-type"] == "application/problem+json"
    problem = response.json()
    assert response.status_code == problem["status"] == status
    assert problem["type"] == f"/problems/{code}"
    assert problem["instance"] == path
    assert problem["errors"] == []


@pytest.mark.anyio
async def test_a_bug_is_a_problem_without_its_secrets() -> None:
    app = FastAPI()
    add_problem_handlers(app)

    @app.get("/")
    def broken() -> None:
        raise RuntimeError("secret")

    transport = httpx.ASGITransport(app, raise_app_exceptions=False)
    async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
        response = await client.get("/")
    assert response.status_code == 500
    assert response.headers["content-type"] == "application/problem+json"
    assert response.json()["type"] == "/problems/internal-error"
    assert "secret" not in response.text


def test_the_documentation_names_the_problem_document(client: httpx.Client) -> None:
    description = client.get("/openapi.json").json()
    responses = description["paths"]["/v1/predictions"]["post"]["responses"]
    assert "application/problem+json" in responses["default"]["content"]
