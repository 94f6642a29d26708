"""Connections that say little or nothing, against a running service."""

import socket
import time

import httpx
import pytest

from app.protocol import HEADERS_S


@pytest.mark.parametrize(
    "begun", [b"", b"GET /heal", b"GET /healthz HTTP/1.1\r\nHost: a\r\nX: "], ids=["none", "line", "header"]
)
def test_headers_that_do_not_come_are_not_waited_for(server: str, begun: bytes) -> None:
    url = httpx.URL(server)
    with socket.create_connection((url.host, url.port or 80)) as connection:
        connection.sendall(begun)
        started = time.monotonic()
        connection.settimeout(3 * HEADERS_S)
        assert connection.recv(100) == b""
        assert time.monotonic() - started > HEADERS_S / 2


def test_a_connection_is_used_again(server: str) -> None:
    with httpx.Client(base_url=server) as client:
        for _ in range(3):
            assert client.get("/healthz").status_code == 200
            time.sleep(1)


def test_scraps_after_an_answer_are_no_reason_to_wait(server: str) -> None:
    url = httpx.URL(server)
    with socket.create_connection((url.host, url.port or 80)) as connection:
        connection.sendall(b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n")
        assert b"200" in connection.recv(10_000)
        connection.sendall(b"\r\n")
        connection.settimeout(3 * HEADERS_S)
        while connection.recv(10_000):
            pass
