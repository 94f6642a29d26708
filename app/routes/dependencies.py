"""What endpoints are given."""

import re
from dataclasses import dataclass
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
_WAIT = re.compile(r"wait=\d{1,6}")
APPLIED = "Preference-Applied"
"""Header of answers to a request with Prefer: what of it counted."""


@dataclass(frozen=True)
class Preference:
    """Of the header Prefer (RFC 7240).

    Attributes:
        wait_s: seconds that the client would wait.
        respond_async: whether it would rather ask again than wait longer.
    """

    wait_s: float
    respond_async: bool


async def _preference(
    prefer: Annotated[
        str, Header(description="`wait=N`: seconds to wait; `respond-async`: rather an address to ask later than to wait")
    ] = "",
) -> Preference:
    preferences = [part.strip().lower() for part in re.split("[,;]", prefer)]
    waits = [float(part[5:]) for part in preferences if _WAIT.fullmatch(part)]
    return Preference(min(*waits, LONGEST_WAIT_S) if waits else 0.0, "respond-async" in preferences)


PreferenceDependency = Annotated[Preference, Depends(_preference)]
ServiceDependency = Annotated[Service, Depends(_service)]


async def _predictions(service: ServiceDependency) -> Predictions:
    return Predictions(service)


async def _jobs(service: ServiceDependency) -> Jobs:
    return Jobs(service)


PredictionsDependency = Annotated[Predictions, Depends(_predictions)]
JobsDependency = Annotated[Jobs, Depends(_jobs)]
