"""Problem documents (RFC 9457): the one shape of every refusal and failure."""

import logging
from http import HTTPStatus

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel
from starlette.exceptions import HTTPException

from app.documentation import Documented
from app.errors import (
    ArchiveError,
    InternalError,
    InvalidFormError,
    MalformedRequestError,
    MethodNotAllowedError,
    NotFoundError,
    RateLimitedError,
    UploadError,
)
from app.forms import field_errors
from app.problem import MEDIA_TYPE, FieldProblem, Problem
from app.requests import BatchForm, PredictionForm, SolveForm, SweepForm
from solver.errors import (
    AsperityError,
    InvalidHeightsError,
    InvalidLoadError,
    InvalidMaterialError,
    InvalidPixelSizeError,
)
from worker.errors import StoreUnavailableError, WebhookError

RETRY_AFTER_SECONDS = 10

UNREAD = (
    HTTPStatus.REQUEST_TIMEOUT,
    HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
    HTTPStatus.UNAUTHORIZED,
    HTTPStatus.FORBIDDEN,
    HTTPStatus.TOO_MANY_REQUESTS,
)
"""Answered before the body was read, or while it came: what is still coming is not listened to."""

FIELD_OF: dict[type[AsperityError], str] = {
    ArchiveError: "archive",
    UploadError: "surface",
    InvalidHeightsError: "surface",
    InvalidLoadError: "load_n",
    InvalidPixelSizeError: "pixel_size_um",
    InvalidMaterialError: "effective_modulus_gpa",
    WebhookError: "webhook_url",
}
"""Field of the form that an error of the lower floors concerns."""

FORMS: dict[str, type[BaseModel]] = {
    "/v1/predictions": PredictionForm,
    "/v1/solves": SolveForm,
    "/v1/sweeps": SweepForm,
    "/v1/batches": BatchForm,
}
"""Forms whose fields have a meaning to tell, by their route."""

logger = logging.getLogger(__name__)


def add_problem_handlers(app: FastAPI) -> None:
    """Answer every error of the application with a problem document."""
    app.add_exception_handler(AsperityError, _on_asperity_error)
    app.add_exception_handler(RequestValidationError, _on_validation_error)
    app.add_exception_handler(HTTPException, _on_http_exception)
    app.add_exception_handler(Exception, _on_bug)


def problem_of(error: AsperityError, instance: str) -> Problem:
    """The problem document of a typed error."""
    detail = str(error)
    if isinstance(error, InvalidFormError):
        errors = [FieldProblem(field=each.field, code=each.code, detail=each.detail) for each in error.errors]
    else:
        fields = [field for kind, field in FIELD_OF.items() if isinstance(error, kind)][:1]
        errors = [FieldProblem(field=field, code=error.code, detail=detail) for field in fields]
    return Problem(
        type=f"/problems/{error.code}",
        title=error.title,
        status=error.http_status,
        detail=detail,
        instance=instance,
        errors=errors,
    )


def problem_response(error: AsperityError, instance: str) -> JSONResponse:
    """The answer to a request that met a typed error."""
    headers = {"Retry-After": str(error.retry_after_s)} if isinstance(error, RateLimitedError) else None
    return problem_document(problem_of(error, instance), headers)


def _on_asperity_error(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, AsperityError)  # noqa: S101 (registered for it)
    return problem_response(error, request.url.path)


def _on_validation_error(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)  # noqa: S101 (registered for it)
    of_route = [form for path, form in FORMS.items() if request.url.path.startswith(path)]
    return _on_asperity_error(request, InvalidFormError(field_errors(error.errors(), [*of_route, *FORMS.values()])))


def _on_http_exception(request: Request, error: Exception) -> JSONResponse:
    """Unknown routes, wrong methods, bodies that are no form."""
    assert isinstance(error, HTTPException)  # noqa: S101 (registered for it)
    if isinstance(error.__cause__, AsperityError):  # raised while the body was read
        return _on_asperity_error(request, error.__cause__)
    if isinstance(error.__cause__, OSError):  # the upload could not be kept
        return _on_asperity_error(request, StoreUnavailableError.of(error.__cause__))
    path, headers = request.url.path, dict(error.headers or {})
    match error.status_code:
        case HTTPStatus.NOT_FOUND:
            known: AsperityError = NotFoundError(f"There is nothing at {path}; /docs lists what there is.")
        case HTTPStatus.METHOD_NOT_ALLOWED:
            known = MethodNotAllowedError(f"{request.method} is not possible at {path}; /docs lists what is.")
            if isinstance(request.app, Documented) and (methods := request.app.methods(path)):
                headers["Allow"] = methods
        case _:
            known = MalformedRequestError(f"The request cannot be read: {error.detail}.")
    return problem_document(problem_of(known, path), headers)


def _on_bug(request: Request, error: Exception) -> JSONResponse:
    logger.error("%s %s failed", request.method, request.url.path, exc_info=error)
    return problem_response(InternalError(), request.url.path)


def problem_document(problem: Problem, headers: dict[str, str] | None = None) -> JSONResponse:
    """A problem as an answer, with the headers that go with its status."""
    headers = headers or {}
    if problem.status == HTTPStatus.SERVICE_UNAVAILABLE:
        headers["Retry-After"] = str(RETRY_AFTER_SECONDS)
    if problem.status in UNREAD:
        headers["Connection"] = "close"
    if problem.status == HTTPStatus.UNAUTHORIZED:
        headers["WWW-Authenticate"] = "Bearer"
    return JSONResponse(problem.model_dump(), problem.status, headers, MEDIA_TYPE)
