"""Reference solves without a prediction."""

from typing import Annotated

from fastapi import APIRouter, Form, Response

from app.documentation import Responses, link, problems
from app.errors import IdempotencyKeyReusedError
from app.requests import SolveForm
from app.routes.dependencies import APPLIED, IdempotencyKey, JobsDependency, PreferenceDependency
from app.routes.problem_groups import QUEUEING, READING
from app.schemas import SolveAnswer

ANSWERS: Responses = {
    202: {
        "links": {
            "job": link("read_job", "job_id", "/job/job_id"),
            "events": link("follow_job", "job_id", "/job/job_id"),
            "mask": link("read_reference_mask", "job_id", "/job/job_id"),
            "cancel": link("cancel_job", "job_id", "/job/job_id"),
        }
    }
}

router = APIRouter(prefix="/v1/solves", tags=["solves"])


@router.post("", status_code=202, responses=ANSWERS | problems(*READING, *QUEUEING, IdempotencyKeyReusedError))
async def queue_solve(
    form: Annotated[SolveForm, Form(media_type="multipart/form-data")],
    jobs: JobsDependency,
    response: Response,
    preference: PreferenceDependency,
    idempotency_key: IdempotencyKey = None,
) -> SolveAnswer:
    """Queue a reference solve; its job says where it stands, and in the end holds the solution."""
    answer = await jobs.solve(await form.files(), form, idempotency_key)
    response.headers["Location"] = answer.job.url
    if preference.wait_s:
        response.headers[APPLIED] = f"wait={preference.wait_s:g}"
        answer.job = await jobs.waited(answer.job, preference.wait_s)
    return answer
