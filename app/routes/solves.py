"""Reference solves without a prediction."""

from typing import Annotated

from fastapi import APIRouter, Form

from app.requests import SolveForm
from app.routes.dependencies import IdempotencyKey, JobsDependency, SecondsToWait
from app.schemas import SolveAnswer

router = APIRouter(prefix="/v1/solves", tags=["solves"])


@router.post("", status_code=202)
async def queue_solve(
    form: Annotated[SolveForm, Form(media_type="multipart/form-data")],
    jobs: JobsDependency,
    wait_s: SecondsToWait,
    idempotency_key: IdempotencyKey = None,
) -> SolveAnswer:
    """Queue a reference solve; its job says where it stands, and in the end holds the solution."""
    answer = await jobs.solve(await form.files(), form, idempotency_key)
    if wait_s:
        answer.job = await jobs.waited(answer.job, wait_s)
    return answer
