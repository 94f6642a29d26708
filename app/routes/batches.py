"""Batches: many height maps in one archive."""

from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Form
from fastapi.responses import StreamingResponse

from app.documentation import Responses, problems
from app.requests import BatchForm
from app.routes.dependencies import PredictionsDependency
from app.routes.problem_groups import COMPUTING, READING
from app.schemas import BatchItem

ANSWERS: Responses = {200: {"model": BatchItem, "description": "a line each"}}

router = APIRouter(prefix="/v1/batches", tags=["batches"])


class Lines(StreamingResponse):
    """Lines of JSON."""

    media_type = "application/x-ndjson"


@router.post(
    "",
    response_class=Lines,
    responses=ANSWERS | problems(*READING, *COMPUTING),
)
async def predict_batch(
    form: Annotated[BatchForm, Form(media_type="multipart/form-data")], predictions: PredictionsDependency
) -> Lines:
    """Predict for all height maps of a zip file: a line of JSON each, sent as soon as it is computed."""
    items = await predictions.batch(await form.archive.read(), form)
    return Lines(_lines(items))


async def _lines(items: AsyncIterator[BatchItem]) -> AsyncIterator[str]:
    async for item in items:
        yield item.model_dump_json() + "\n"
