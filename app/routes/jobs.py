"""Verification jobs: followed, canceled, and their reference mask."""

from fastapi import APIRouter, Response

from app.routes.dependencies import ServiceDependency
from app.schemas import JobAnswer

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])


@router.get("/{job_id}")
def read_job(job_id: str, service: ServiceDependency) -> JobAnswer:
    """Status, progress and, once finished, the reference and its comparison with the prediction."""
    return service.job(job_id)


@router.delete("/{job_id}")
def cancel_job(job_id: str, service: ServiceDependency) -> JobAnswer:
    """Cancel a job, whether it waits or runs."""
    return service.cancel(job_id)


@router.get("/{job_id}/mask.png", response_class=Response, responses={200: {"content": {"image/png": {}}}})
def read_reference_mask(job_id: str, service: ServiceDependency) -> Response:
    """The reference mask of a finished job: 1-bit PNG, white in contact."""
    return Response(service.reference_mask(job_id), media_type="image/png")
