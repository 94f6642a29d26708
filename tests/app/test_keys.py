"""API keys: who may do what, and how often."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
import pytest

from app.api_key import new_key
from app.errors import ForbiddenError, RateLimitedError, UnauthorizedError
from app.keys import Gate
from app.main import create_app
from app.settings import Settings, read_settings
from tests.app.conftest import UNITS, run
from tests.app.files import surface_png


def test_without_keys_everyone_may_do_everything() -> None:
    for _ in range(100):
        Gate([], None).admit(None, "write", "1.2.3.4")


def test_a_key_opens_what_its_scopes_say() -> None:
    secret, key = new_key("someone")
    assert secret not in key.model_dump_json()
    gate = Gate([key.model_copy(update={"scopes": {"read"}})], None)
    gate.admit(secret, "read", "")
    with pytest.raises(ForbiddenError, match="someone lacks the scope write"):
        gate.admit(secret, "write", "")
    for wrong in (None, "", secret[:-1], key.sha256):
        with pytest.raises(UnauthorizedError):
            gate.admit(wrong, "read", "")


def test_a_client_has_so_many_requests_a_minute() -> None:
    gate = Gate([], 3)
    for _ in range(3):
        gate.admit(None, "read", "1.2.3.4")
    with pytest.raises(RateLimitedError, match="More than 3"):
        gate.admit(None, "read", "1.2.3.4")
    gate.admit(None, "read", "5.6.7.8")


def test_a_key_has_a_limit_of_its_own() -> None:
    secret, key = new_key("slow")
    gate = Gate([key.model_copy(update={"requests_per_minute": 1})], 100)
    gate.admit(secret, "read", "1.2.3.4")
    with pytest.raises(RateLimitedError):
        gate.admit(secret, "read", "5.6.7.8")


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
    Gate(keys, None).admit(secret, "write", "")
    assert json.loads(keys[0].model_dump_json())["name"] == "a client"
