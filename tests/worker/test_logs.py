"""Logs as JSON, with the id of the request."""

import json
import logging
from collections.abc import Iterator

import pytest

from worker.logs import log_as_json, request_id


@pytest.fixture
def restored() -> Iterator[None]:
    root = logging.getLogger()
    handlers, level = list(root.handlers), root.level
    yield
    root.handlers[:] = handlers
    root.setLevel(level)


def test_a_line_is_a_json_object(restored: None, capsys: pytest.CaptureFixture[str]) -> None:
    log_as_json()
    logger = logging.getLogger("some.part")
    logger.info("no %s", "request")
    token = request_id.set("abc")
    logger.warning("in a request", extra={"status": 418})
    request_id.reset(token)
    first, second = map(json.loads, capsys.readouterr().err.splitlines())
    assert (first["level"], first["name"], first["message"]) == ("INFO", "some.part", "no request")
    assert "request_id" not in first
    assert (second["request_id"], second["status"]) == ("abc", 418)
    assert second["time"] >= first["time"]
