"""What endpoints are given."""

import re
from typing import Annotated

from fastapi import Depends, Header, Query, Request

from app.jobs import Jobs
from app.predictions import Predictions
from app.service import Service


async def _service(request: Request) -> Service:
    service: Service = request.app.state.service
    return service


Limit = Annotated[int, Query(ge=1, le=100, description="items a page")]
Before = Annotated[str | None, Query(description="id of an item; older ones are listed")]
IdempotencyKey = Annotated[str | None, Header(max_length=255, description="the same key and request count once")]
LONGEST_WAIT_S = 60.0
_WAIT = re.compile(r"(?:^|[,;\s])wait=(\d{1,6})")


async def _seconds_to_wait(
    prefer: Annotated[str, Header(description="`wait=N`: seconds to wait for the job")] = "",
) -> float:
    """Of the header Prefer (RFC 7240)."""
    found = _WAIT.search(prefer)
    return min(float(found[1]), LONGEST_WAIT_S) if found else 0.0


SecondsToWait = Annotated[float, Depends(_seconds_to_wait)]
ServiceDependency = Annotated[Service, Depends(_service)]


async def _predictions(service: ServiceDependency) -> Predictions:
    return Predictions(service)


async def _jobs(service: ServiceDependency) -> Jobs:
    return Jobs(service)


PredictionsDependency = Annotated[Predictions, Depends(_predictions)]
JobsDependency = Annotated[Jobs, Depends(_jobs)]
