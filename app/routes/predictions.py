"""Predictions: made from an upload, read again by their id."""

import asyncio
from collections.abc import Mapping
from typing import Annotated

from fastapi import APIRouter, Form, Response
from fastapi.responses import JSONResponse

from app.documentation import NETCDF, NPY, PNG, Responses, file, link, problems
from app.errors import IdempotencyKeyReusedError, InvalidFormError
from app.fields import FieldName
from app.problem import Problem
from app.problems import problem_document
from app.requests import PredictionForm
from app.routes.dependencies import (
    APPLIED,
    Before,
    IdempotencyKey,
    JobsDependency,
    Limit,
    PredictionsDependency,
    PreferenceDependency,
)
from app.routes.problem_groups import COMPUTING, QUEUEING, READING, STORED
from app.schemas import Page, Pending, PredictionAnswer

EXAMPLE = Pending(id="0" * 32, url=f"/v1/predictions/{'0' * 32}").model_dump()
PENDING: Responses = {
    202: {
        "model": Pending,
        "description": "It is computed; ask at `url` later",
        "content": {"application/json": {"example": EXAMPLE}},
    }
}
ANSWERS: Responses = {
    200: {
        "links": {
            "prediction": link("read_prediction", "prediction_id", "/id"),
            "mask": link("read_mask", "prediction_id", "/id"),
            "bundle": link("read_bundle", "prediction_id", "/id"),
            "verification": link("read_job", "job_id", "/verification/job_id"),
        }
    }
}

router = APIRouter(prefix="/v1/predictions", tags=["predictions"])


@router.post(
    "",
    response_model=PredictionAnswer,
    responses=ANSWERS | PENDING | problems(*READING, *COMPUTING, *QUEUEING, IdempotencyKeyReusedError),
)
async def make_prediction(
    form: Annotated[PredictionForm, Form(media_type="multipart/form-data")],
    predictions: PredictionsDependency,
    jobs: JobsDependency,
    response: Response,
    preference: PreferenceDependency,
    idempotency_key: IdempotencyKey = None,
) -> PredictionAnswer | Response:
    """Predict the contact of a height map, and have it verified by the reference solver unless told not to.

    The same upload with the same fields is computed once; the header `Asperity-Cache` says `hit` where it was there.
    With `Prefer: wait=N` the answer waits for the verification, with `respond-async` for nothing: 202 says where to ask.
    """
    files = await form.files()
    if preference.respond_async:
        pending, computing = await predictions.begin(files, form, idempotency_key)
        if not (await asyncio.wait({asyncio.ensure_future(computing)}, timeout=preference.wait_s))[0]:
            return _accepted(pending, {APPLIED: "respond-async"})
        answer, known = await computing
    else:
        answer, known = await predictions.predict(files, form, idempotency_key)
    response.headers["Asperity-Cache"] = "hit" if known else "miss"
    if preference.wait_s and not preference.respond_async and answer.verification:
        answer.verification = await jobs.waited(answer.verification, preference.wait_s)
    if preference.wait_s and (preference.respond_async or answer.verification):
        response.headers[APPLIED] = f"wait={preference.wait_s:g}"
    return answer


def _accepted(pending: Pending, headers: Mapping[str, str] | None = None) -> Response:
    return JSONResponse(pending.model_dump(), 202, {"Location": pending.url, "Retry-After": "1", **(headers or {})})


@router.get("", responses=problems(InvalidFormError, *STORED))
def list_predictions(predictions: PredictionsDependency, limit: Limit = 20, before: Before = None) -> Page[PredictionAnswer]:
    """All predictions that are kept, newest first."""
    return predictions.newest(limit, before)


@router.get("/{prediction_id}", response_model=PredictionAnswer, responses=PENDING | problems(*STORED))
def read_prediction(prediction_id: str, predictions: PredictionsDependency) -> PredictionAnswer | Response:
    """The answer that was given; 202 while it is computed, and then the problem if there was one."""
    match predictions.outcome(prediction_id):
        case Pending() as pending:
            return _accepted(pending)
        case Problem() as problem:
            return problem_document(problem)
        case PredictionAnswer() as answer:
            return answer


@router.get("/{prediction_id}/mask.png", response_class=Response, responses=file(PNG) | problems(*STORED))
def read_mask(prediction_id: str, predictions: PredictionsDependency) -> Response:
    """The predicted mask: 1-bit PNG, white in contact, rows and columns as uploaded."""
    return Response(predictions.mask(prediction_id), media_type=PNG)


@router.get(
    "/{prediction_id}/{name}.npy", response_class=Response, responses=file(NPY) | problems(InvalidFormError, *STORED)
)
def read_field(prediction_id: str, name: FieldName, predictions: PredictionsDependency) -> Response:
    """A field that was asked for by outputs: a NumPy array, in SI units."""
    return Response(predictions.field_npy(prediction_id, name), media_type=NPY)


@router.get(
    "/{prediction_id}/{name}.png", response_class=Response, responses=file(PNG) | problems(InvalidFormError, *STORED)
)
def read_picture(prediction_id: str, name: FieldName, predictions: PredictionsDependency) -> Response:
    """The same as a 16-bit grey PNG; what black and white mean is in the prediction."""
    return Response(predictions.field_png(prediction_id, name), media_type=PNG)


@router.get("/{prediction_id}/bundle.nc", response_class=Response, responses=file(NETCDF) | problems(*STORED))
def read_bundle(prediction_id: str, predictions: PredictionsDependency) -> Response:
    """The mask and all fields that were asked for: a netCDF 3 file with a unit on every variable."""
    return Response(predictions.bundle(prediction_id), media_type=NETCDF)
