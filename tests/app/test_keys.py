"""API keys: who may do what, and how often."""

import json
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI

from app.api_key import new_key
from app.errors import ForbiddenError, RateLimitedError, UnauthorizedError
from app.keys import Gate
from app.main import create_app
from app.settings import Settings, read_settings
from tests.app.conftest import UNITS, run
from tests.app.files import surface_png
from worker.embedded_redis import EmbeddedRedis


def gate(**given: object) -> Gate:
    """With nothing behind it, and no Redis."""
    return Gate(FastAPI(), Settings(state_dir=Path("/nowhere"), **given))  # type: ignore[arg-type]


def test_without_keys_everyone_may_do_everything() -> None:
    assert gate().admit(None, "write", "1.2.3.4") == ("1.2.3.4", None)


def test_a_key_opens_what_its_scopes_say() -> None:
    secret, key = new_key("someone")
    assert secret not in key.model_dump_json()
    reading = gate(api_keys=[key.model_copy(update={"scopes": {"read"}})])
    reading.admit(secret, "read", "")
    with pytest.raises(ForbiddenError, match="someone lacks the scope write"):
        reading.admit(secret, "write", "")
    for wrong in (None, "", secret[:-1], key.sha256):
        with pytest.raises(UnauthorizedError):
            reading.admit(wrong, "read", "")


def test_a_client_has_so_many_requests_a_minute() -> None:
    limited = gate(requests_per_minute=3)
    for _ in range(3):
        limited.count("1.2.3.4", 3)
    with pytest.raises(RateLimitedError, match="More than 3") as refusal:
        limited.count("1.2.3.4", 3)
    assert 50 <= refusal.value.retry_after_s <= 60
    limited.count("5.6.7.8", 3)


def test_a_key_has_a_limit_of_its_own() -> None:
    secret, key = new_key("slow")
    limited = gate(api_keys=[key.model_copy(update={"requests_per_minute": 1})], requests_per_minute=100)
    assert limited.admit(secret, "read", "1.2.3.4") == limited.admit(secret, "read", "5.6.7.8") == (key.sha256, 1)


def test_services_that_share_a_redis_share_the_count() -> None:
    with tempfile.TemporaryDirectory(prefix="asperity-") as state, EmbeddedRedis(Path(state)):
        first, second = (Gate(FastAPI(), Settings(state_dir=Path(state))) for _ in range(2))
        first.count("a client", 2)
        second.count("a client", 2)
        for one in (first, second):
            with pytest.raises(RateLimitedError):
                one.count("a client", 2)


@asynccontextmanager
async def running(settings: Settings) -> AsyncIterator[httpx.AsyncClient]:
    app = create_app(settings)
    async with (
        app.router.lifespan_context(app),
        httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://test") as client,
    ):
        yield client


@pytest.mark.anyio
async def test_the_service_asks_for_keys_and_counts(tmp_path: Path) -> None:
    secret, key = new_key("design tool")
    request = {"data": UNITS | {"verify": "false"}, "files": {"surface": surface_png()}}
    known = {"Authorization": f"Bearer {secret}"}
    limited = key.model_copy(update={"requests_per_minute": 2})
    async with running(Settings(state_dir=tmp_path, api_keys=[limited])) as client:
        without = await client.post("/v1/predictions", **request)  # type: ignore[arg-type]
        assert without.status_code == 401
        assert without.headers["www-authenticate"] == "Bearer"
        assert without.json()["type"] == "/problems/unauthorized"
        assert (await client.get("/healthz")).status_code == 200
        answers = [await client.post("/v1/predictions", headers=known, **request) for _ in range(3)]  # type: ignore[arg-type]
    assert [answer.status_code for answer in answers] == [200, 200, 429]
    assert int(answers[2].headers["retry-after"]) > 0


def test_the_command_makes_what_the_settings_take(monkeypatch: pytest.MonkeyPatch) -> None:
    done = run("key", "a client")
    first, second = done.stdout.strip().splitlines()
    secret = first.rpartition(" ")[2]
    monkeypatch.setenv("ASPERITY_API_KEYS", second.partition("=")[2].strip("'"))
    keys = read_settings().api_keys
    gate(api_keys=keys).admit(secret, "write", "")
    assert json.loads(keys[0].model_dump_json())["name"] == "a client"
