"""OpenTelemetry: spans of requests, of what computes for them, and of their jobs, in one trace.

Without a collector spans go nowhere and cost next to nothing.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from opentelemetry import trace
from opentelemetry.propagate import extract, inject

from worker.errors import TracingError

ENDPOINT = "OTEL_EXPORTER_OTLP_ENDPOINT"

AT_ONCE_S = 1.0
"""Longest that something waits for a collector; what cannot be sent by then is forgotten."""

Carrier = dict[str, str]
"""A place in a trace as text, for another process (W3C Trace Context)."""


def send_traces(service: str, at_once: bool = False) -> None:
    """Send the spans of this process to the collector of OTEL_EXPORTER_OTLP_ENDPOINT, if it is set.

    Args:
        service: name of what runs here.
        at_once: as each span ends, rather than now and then from a thread.

    Raises:
        TracingError: what sends is not installed.
    """
    if not os.environ.get(ENDPOINT):
        return
    try:
        from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
        from opentelemetry.sdk.resources import Resource
        from opentelemetry.sdk.trace import TracerProvider
        from opentelemetry.sdk.trace.export import BatchSpanProcessor, SimpleSpanProcessor
    except ImportError as error:
        raise TracingError(
            f"{ENDPOINT} is set, but nothing is installed that sends: pip install 'asperity[tracing]'."
        ) from error
    provider = TracerProvider(resource=Resource.create({"service.name": service}))
    processor = SimpleSpanProcessor if at_once else BatchSpanProcessor
    provider.add_span_processor(processor(OTLPSpanExporter(timeout=AT_ONCE_S if at_once else None)))
    trace.set_tracer_provider(provider)


def carrier() -> Carrier:
    """Where this process is in a trace."""
    place: Carrier = {}
    inject(place)
    return place


@contextmanager
def span(name: str, place: Carrier) -> Iterator[None]:
    """A span under a place that came from another process."""
    with trace.get_tracer("asperity").start_as_current_span(name, context=extract(place)):
        yield
