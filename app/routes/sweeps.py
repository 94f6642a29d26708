"""Load sweeps: one surface under many loads, streamed as they are computed."""

import csv
import io
from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Form, Header
from fastapi.responses import StreamingResponse

from app.documentation import Responses, problems
from app.requests import SweepForm
from app.routes.dependencies import ServiceDependency
from app.routes.problem_groups import COMPUTING, READING
from app.schemas import SweepAnswer, SweepPoint
from app.sweep import sweep as compute_sweep

CSV = "text/csv"
ANSWERS: Responses = {
    200: {"model": SweepAnswer, "content": {CSV: {}}, "description": "as JSON, or as CSV if accepted first"}
}

router = APIRouter(prefix="/v1/sweeps", tags=["sweeps"])


@router.post(
    "",
    response_class=StreamingResponse,
    responses=ANSWERS | problems(*READING, *COMPUTING),
)
async def sweep(
    form: Annotated[SweepForm, Form(media_type="multipart/form-data")],
    service: ServiceDependency,
    accept: Annotated[str, Header()] = "*/*",
) -> StreamingResponse:
    """Area, resistance, stiffness and spots against load; each point is sent as soon as it is computed."""
    answer, points = await compute_sweep(service, await form.files(), form)
    if accept.startswith(CSV):
        return StreamingResponse(_as_csv(points), media_type=CSV)
    return StreamingResponse(_as_json(answer, points), media_type="application/json")


async def _as_json(answer: SweepAnswer, points: AsyncIterator[SweepPoint]) -> AsyncIterator[str]:
    """The answer with its empty list of points filled in."""
    yield answer.model_dump_json().removesuffix("]}")
    separator = ""
    async for point in points:
        yield separator + point.model_dump_json()
        separator = ",\n"
    yield "]}"


async def _as_csv(points: AsyncIterator[SweepPoint]) -> AsyncIterator[str]:
    yield _line(list(SweepPoint.model_fields))
    async for point in points:
        yield _line(list(point.model_dump().values()))


def _line(cells: list[object]) -> str:
    file = io.StringIO()
    csv.writer(file).writerow(cells)
    return file.getvalue()
