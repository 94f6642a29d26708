"""Jobs: listed, followed, canceled, and the fields of their solutions."""

import asyncio
from collections.abc import AsyncIterator
from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Depends, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from app.documentation import NPY, PNG, file, problems
from app.errors import InvalidFormError
from app.jobs import ENDED, LOOK_EVERY_S
from app.routes.dependencies import Before, JobsDependency, Limit
from app.routes.problem_groups import JOB
from app.schemas import JobAnswer, Page
from worker.parcel import FieldName

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])


@router.get("", responses=problems(InvalidFormError, *JOB))
def list_jobs(jobs: JobsDependency, limit: Limit = 20, before: Before = None) -> Page[JobAnswer]:
    """All jobs that are kept, newest first."""
    return jobs.newest(limit, before)


@router.get("/{job_id}", responses=problems(*JOB))
def read_job(job_id: str, jobs: JobsDependency) -> JobAnswer:
    """Status, progress and, once finished, the reference and its comparison with the prediction."""
    return jobs.read(job_id)


@router.get("/{job_id}/events", response_class=EventSourceResponse, responses=problems(*JOB))
async def follow_job(job: Annotated[JobAnswer, Depends(read_job)], jobs: JobsDependency) -> AsyncIterator[ServerSentEvent]:
    """The job now and each time that it has changed, as server-sent events named by its status, until it has ended."""
    yield ServerSentEvent(data=job, event=job.status)
    while job.status not in ENDED:
        await asyncio.sleep(LOOK_EVERY_S)
        before, job = job, await to_thread.run_sync(jobs.read, job.id)
        if job != before:
            yield ServerSentEvent(data=job, event=job.status)


@router.delete("/{job_id}", responses=problems(*JOB))
def cancel_job(job_id: str, jobs: JobsDependency) -> JobAnswer:
    """Cancel a job, whether it waits or runs."""
    return jobs.cancel(job_id)


@router.get("/{job_id}/mask.png", response_class=Response, responses=file(PNG) | problems(*JOB))
def read_reference_mask(job_id: str, jobs: JobsDependency) -> Response:
    """The reference mask of a finished job: 1-bit PNG, white in contact."""
    return Response(jobs.reference_mask(job_id), media_type=PNG)


@router.get("/{job_id}/{name}.npy", response_class=Response, responses=file(NPY) | problems(InvalidFormError, *JOB))
def read_reference_field(job_id: str, name: FieldName, jobs: JobsDependency) -> Response:
    """A field of the reference solution that was asked for by outputs: a NumPy array, in SI units."""
    return Response(jobs.field(job_id, name), media_type=NPY)
