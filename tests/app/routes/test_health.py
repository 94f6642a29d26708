"""Liveness and readiness, with and without what the service needs."""

import asyncio
import multiprocessing
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
import pytest

from app.main import create_app
from app.settings import Settings
from model import Surrogate
from tests.app.conftest import UNITS
from tests.app.files import surface_png


@asynccontextmanager
async def running(state: Path, **settings: object) -> AsyncIterator[httpx.AsyncClient]:
    """The application in this process, with a state directory where no Redis runs."""
    app = create_app(Settings(state_dir=state, **settings))  # type: ignore[arg-type]
    async with (
        app.router.lifespan_context(app),
        httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://test") as client,
    ):
        yield client


def test_ready(client: httpx.Client) -> None:
    assert client.get("/healthz").json()["status"] == "ok"
    ready = client.get("/readyz").json()
    assert ready == {"status": "ok", "model": Surrogate.load().version}


@pytest.mark.anyio
async def test_not_ready_without_redis(tmp_path: Path) -> None:
    async with running(tmp_path) as client:
        assert (await client.get("/healthz")).status_code == 200
        response = await client.get("/readyz")
    assert response.status_code == 503
    assert response.json()["type"] == "/problems/queue-unavailable"
    assert int(response.headers["retry-after"]) > 0


@pytest.mark.anyio
async def test_only_verification_needs_redis(tmp_path: Path) -> None:
    files = {"surface": ("surface.png", surface_png(), "image/png")}
    async with running(tmp_path) as client:
        without = await client.post("/v1/predictions", data=UNITS | {"verify": "false"}, files=files)
        with_verification = await client.post("/v1/predictions", data=UNITS, files=files)
    assert without.status_code == 200
    assert with_verification.json()["type"] == "/problems/queue-unavailable"


@pytest.mark.anyio
async def test_not_ready_without_weights(tmp_path: Path) -> None:
    async with running(tmp_path, weights=tmp_path) as client:
        assert (await client.get("/healthz")).status_code == 200
        response = await client.get("/readyz")
        asked = await client.post("/v1/predictions", data=UNITS, files={"surface": surface_png()})
    assert response.status_code == asked.status_code == 503
    assert response.json()["type"] == asked.json()["type"] == "/problems/weights-unavailable"


@pytest.mark.anyio
async def test_a_process_that_dies_is_replaced(tmp_path: Path) -> None:
    """Its request is computed again; the next one finds new processes."""
    async with running(tmp_path, compute_processes=1) as client:
        (victim,) = [child for child in multiprocessing.active_children() if "Spawn" in child.name]
        asking = asyncio.create_task(
            client.post("/v1/predictions", data=UNITS | {"verify": "false"}, files={"surface": surface_png(1024)})
        )
        await asyncio.sleep(0.2)
        victim.kill()
        assert (await asking).status_code == 200
        again = await client.post("/v1/predictions", data=UNITS | {"verify": "false"}, files={"surface": surface_png()})
    assert again.status_code == 200
