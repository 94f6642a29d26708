"""Predictions: made from an upload, read again by their id."""

from typing import Annotated

from fastapi import APIRouter, Form, Response

from app.routes.dependencies import ServiceDependency
from app.schemas import PredictionAnswer, PredictionForm

router = APIRouter(prefix="/v1/predictions", tags=["predictions"])


@router.post("")
async def make_prediction(
    form: Annotated[PredictionForm, Form(media_type="multipart/form-data")], service: ServiceDependency
) -> PredictionAnswer:
    """Predict the contact of a height map, and have it verified by the reference solver unless told not to."""
    return await service.predict(await form.files(), form)


@router.get("/{prediction_id}")
def read_prediction(prediction_id: str, service: ServiceDependency) -> PredictionAnswer:
    """The answer that was given."""
    return service.prediction(prediction_id)


@router.get("/{prediction_id}/mask.png", response_class=Response, responses={200: {"content": {"image/png": {}}}})
def read_mask(prediction_id: str, service: ServiceDependency) -> Response:
    """The predicted mask: 1-bit PNG, white in contact, rows and columns as uploaded."""
    return Response(service.mask(prediction_id), media_type="image/png")
