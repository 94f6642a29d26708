"""Typed errors of queue, jobs and stored results."""

from solver.errors import AsperityError


class QueueUnavailableError(AsperityError):
    """Redis cannot be reached, or cannot be started."""

    code = "queue-unavailable"
    title = "The job queue is not available"
    http_status = 503


class TracingError(AsperityError):
    """Traces that are to be sent and cannot be."""

    code = "tracing-unavailable"
    title = "Traces cannot be sent"


class QueueFullError(AsperityError):
    """More jobs are waiting than may wait."""

    code = "queue-full"
    title = "Too many jobs are waiting"
    http_status = 503


class JobTooLargeError(AsperityError):
    """A job that would take more memory than a worker has."""

    code = "job-too-large"
    title = "The job would take too much memory"
    http_status = 413


class WebhookError(AsperityError):
    """A webhook that cannot be, or that was not taken."""

    code = "invalid-webhook"
    title = "The webhook cannot be used"
    http_status = 422


class JobNotFoundError(AsperityError):
    """No job of that id, or it has expired."""

    code = "job-not-found"
    title = "There is no such job"
    http_status = 404


class DamagedResultError(AsperityError):
    """A stored file that is not what was stored."""

    code = "damaged-result"
    title = "The stored result is damaged"


class StoreUnavailableError(AsperityError):
    """The place for results or uploads refuses: it is full, or out of reach."""

    code = "store-unavailable"
    title = "The store is not available"
    http_status = 503

    @classmethod
    def of(cls, error: OSError) -> "StoreUnavailableError":
        """What the operating system or the object store says."""
        return cls(
            f"The service cannot store or read files now ({error.strerror or error}). Nothing is lost; try again later."
        )


class ResultNotFoundError(AsperityError):
    """Nothing is stored under that id and name, or it has expired."""

    code = "result-not-found"
    title = "There is no such result"
    http_status = 404
