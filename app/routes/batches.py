"""Batches: many height maps in one archive."""

from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Form
from fastapi.responses import StreamingResponse

from app.requests import BatchForm
from app.routes.dependencies import PredictionsDependency
from app.schemas import BatchItem

LINES = "application/x-ndjson"

router = APIRouter(prefix="/v1/batches", tags=["batches"])


@router.post("", response_class=StreamingResponse, responses={200: {"model": BatchItem, "content": {LINES: {}}}})
async def predict_batch(
    form: Annotated[BatchForm, Form(media_type="multipart/form-data")], predictions: PredictionsDependency
) -> StreamingResponse:
    """Predict for all height maps of a zip file: a line of JSON each, sent as soon as it is computed."""
    items = await predictions.batch(await form.archive.read(), form)
    return StreamingResponse(_lines(items), media_type=LINES)


async def _lines(items: AsyncIterator[BatchItem]) -> AsyncIterator[str]:
    async for item in items:
        yield item.model_dump_json() + "\n"
