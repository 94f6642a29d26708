"""One trace from the request to the job that it queued."""

import time

import httpx

from tests.app.conftest import UNITS, serving
from tests.app.files import surface_png
from tests.worker.test_tracing import PARENT, TRACE, collector

WANTED = {("asperity", "POST /v1/predictions"), ("asperity-compute", "computed_prediction")}


def test_request_computation_and_job_are_one_trace() -> None:
    with collector() as (endpoint, received), serving(OTEL_EXPORTER_OTLP_ENDPOINT=endpoint) as url:
        httpx.post(f"{url}/v1/predictions", data=UNITS, files={"surface": surface_png()}, headers=PARENT)
        deadline = time.monotonic() + 60
        while True:
            spans = {(service, name) for service, name, trace in received if trace == TRACE}
            if spans >= WANTED and any(service == "asperity-worker" for service, _ in spans):
                break
            assert time.monotonic() < deadline, received
            time.sleep(0.1)
