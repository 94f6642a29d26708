"""Traces, as a collector receives them."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest

from worker import tracing

TRACE = "0af7651916cd43dd8448eb211c80319c"
PARENT = {"traceparent": f"00-{TRACE}-b7ad6b7169203331-01"}


@contextmanager
def collector() -> Iterator[tuple[str, list[tuple[str, str, str]]]]:
    """The URL of a collector, and what it has received: service, span and trace."""
    received: list[tuple[str, str, str]] = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            request = ExportTraceServiceRequest.FromString(self.rfile.read(int(self.headers["content-length"])))
            for resource in request.resource_spans:
                service = next(one.value.string_value for one in resource.resource.attributes if one.key == "service.name")
                for scope in resource.scope_spans:
                    received.extend((service, span.name, span.trace_id.hex()) for span in scope.spans)
            self.send_response(200)
            self.end_headers()

        def log_message(self, *arguments: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}", received
    finally:
        server.shutdown()
        server.server_close()


def test_a_span_goes_to_the_collector_under_its_parent() -> None:
    code = f"""
from worker.tracing import carrier, send_traces, span
send_traces("a test", at_once=True)
with span("solve", {PARENT!r}):
    assert "{TRACE}" in carrier()["traceparent"]
"""
    with collector() as (url, received):
        done = subprocess.run([sys.executable, "-c", code], env=os.environ | {tracing.ENDPOINT: url})
    assert done.returncode == 0
    assert received == [("a test", "solve", TRACE)]


def test_without_a_collector_nothing_is_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(tracing.ENDPOINT, raising=False)
    tracing.send_traces("a test")
    with tracing.span("solve", {}):
        assert tracing.carrier() == {}
