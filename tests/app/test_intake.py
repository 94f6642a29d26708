"""Bodies that are too large or too slow are stopped while they stream."""

import time
from collections.abc import AsyncIterator
from typing import Annotated

import anyio
import httpx
import pytest
from fastapi import FastAPI, File, UploadFile

from app.intake import MEBIBYTE, Intake
from app.problems import MEDIA_TYPE, add_problem_handlers

PREFIX = b'--x\r\nContent-Disposition: form-data; name="surface"; filename="a.png"\r\n\r\n'
SUFFIX = b"\r\n--x--\r\n"
HEADERS = {"content-type": "multipart/form-data; boundary=x"}


@pytest.fixture
def client() -> httpx.AsyncClient:
    app = FastAPI()
    app.add_middleware(Intake, limit_mib=1, piece_s=0.2, body_s=0.6)
    add_problem_handlers(app)

    @app.post("/")
    async def upload(surface: Annotated[UploadFile, File()]) -> int:
        return len(await surface.read())

    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://test")


class Stream:
    """A body without announced length that notes how much of it was taken."""

    def __init__(self, mebibytes: int) -> None:
        self.mebibytes = mebibytes
        self.taken = 0

    async def __aiter__(self) -> AsyncIterator[bytes]:
        yield PREFIX
        for _ in range(self.mebibytes * 16):
            self.taken += MEBIBYTE // 16
            yield bytes(MEBIBYTE // 16)
        yield SUFFIX


def assert_refused(response: httpx.Response) -> None:
    assert response.status_code == 413
    assert response.headers["content-type"] == MEDIA_TYPE
    assert response.json()["type"] == "/problems/upload-too-large"
    assert "1 MiB" in response.json()["detail"]


@pytest.mark.anyio
async def test_a_body_within_the_limit_passes(client: httpx.AsyncClient) -> None:
    content = PREFIX + bytes(MEBIBYTE - len(PREFIX) - len(SUFFIX)) + SUFFIX
    response = await client.post("/", content=content, headers=HEADERS)
    assert response.status_code == 200


@pytest.mark.anyio
async def test_an_announced_length_beyond_the_limit_is_refused(client: httpx.AsyncClient) -> None:
    content = PREFIX + bytes(MEBIBYTE) + SUFFIX
    assert_refused(await client.post("/", content=content, headers=HEADERS))


@pytest.mark.anyio
async def test_a_stream_is_stopped_at_the_limit(client: httpx.AsyncClient) -> None:
    stream = Stream(mebibytes=8)
    assert_refused(await client.post("/", content=aiter(stream), headers=HEADERS))
    assert stream.taken <= 2 * MEBIBYTE


async def _slowly(pauses: list[float]) -> AsyncIterator[bytes]:
    yield PREFIX
    for pause in pauses:
        await anyio.sleep(pause)
        yield b"x"
    yield SUFFIX


@pytest.mark.anyio
async def test_a_slow_stream_within_the_limits_passes(client: httpx.AsyncClient) -> None:
    response = await client.post("/", content=_slowly([0.1, 0.1]), headers=HEADERS)
    assert response.json() == 2


@pytest.mark.anyio
@pytest.mark.parametrize("pauses", [[5.0], [0.1] * 50], ids=["silent", "a drop at a time"])
async def test_a_stream_that_is_too_slow_is_stopped(client: httpx.AsyncClient, pauses: list[float]) -> None:
    started = time.monotonic()
    response = await client.post("/", content=_slowly(pauses), headers=HEADERS)
    assert (response.status_code, response.json()["type"]) == (408, "/problems/slow-upload")
    assert time.monotonic() - started < 2
