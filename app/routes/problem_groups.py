"""Errors that routes have in common, for their documentation."""

from app.errors import (
    BusyError,
    ComputeError,
    ForbiddenError,
    InvalidFormError,
    MalformedRequestError,
    RateLimitedError,
    UnauthorizedError,
    UploadError,
)
from model.errors import AccuracyError, WeightsError
from solver.errors import AsperityError, InvalidProblemError, NotConvergedError
from worker.errors import (
    DamagedResultError,
    JobNotFoundError,
    JobTooLargeError,
    QueueFullError,
    QueueUnavailableError,
    ResultNotFoundError,
    StoreUnavailableError,
    WebhookError,
)

Kinds = tuple[type[AsperityError], ...]

GATE: Kinds = (UnauthorizedError, ForbiddenError, RateLimitedError)
READING: Kinds = (MalformedRequestError, InvalidFormError, UploadError, InvalidProblemError)
COMPUTING: Kinds = (AccuracyError, NotConvergedError, BusyError, ComputeError, WeightsError, StoreUnavailableError)
QUEUEING: Kinds = (JobTooLargeError, QueueFullError, QueueUnavailableError, WebhookError)
STORED: Kinds = (ResultNotFoundError, DamagedResultError, StoreUnavailableError)
JOB: Kinds = (JobNotFoundError, QueueUnavailableError)
