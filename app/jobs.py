"""Jobs: reference solves queued, followed, canceled, and read."""

import asyncio
import time
from dataclasses import asdict

from anyio import to_thread

from app.content import content_id
from app.errors import IdempotencyKeyReusedError
from app.job_link import job_link
from app.reading import Files, read_problem
from app.requests import SolveForm
from app.schemas import JobAnswer, JobLink, Page, SolveAnswer
from app.service import Service
from worker.jobs import JobState
from worker.logs import request_id
from worker.parcel import FieldName as SolveField
from worker.parcel import Parcel
from worker.store import new_id

ENDED = ("finished", "failed", "canceled")
LOOK_EVERY_S = 0.1


class Jobs:
    """Jobs of a service."""

    def __init__(self, service: Service) -> None:
        self.service = service

    async def solve(self, files: Files, form: SolveForm, key: str | None) -> SolveAnswer:
        """Queue a reference solve; for an idempotency key once only.

        Raises:
            AsperityError: bad input, an idempotency key that stands for another request, or no queue.
        """
        return await self.service.in_thread(self._solve, files, form, key)

    def _solve(self, files: Files, form: SolveForm, key: str | None) -> SolveAnswer:
        reading = read_problem(files, form, form.load_n, self.service.sandbox.decode)
        parcel = Parcel(reading.problem, resistivity=form.resistivity_ohm_m, outputs=tuple(form.outputs))
        job_id = new_id()
        if key is not None:
            content = content_id(files, form, "solve")
            claimed, _, first = self.service.store.claim(key, f"{content} {job_id}").partition(" ")
            if claimed != content:
                raise IdempotencyKeyReusedError("This idempotency key stands for another request; choose a new one.")
            if first != job_id:
                return SolveAnswer(job=job_link(first), surface=reading.surface, warnings=reading.warnings)
        self.service.queue().enqueue(parcel, job_id, request_id.get(), form.webhook_url)
        return SolveAnswer(job=job_link(job_id), surface=reading.surface, warnings=reading.warnings)

    async def waited(self, link: JobLink, seconds: float) -> JobLink:
        """A job with where it stands once it has ended, or the time is over.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job, or no queue.
        """
        deadline = time.monotonic() + seconds
        while True:
            state = await to_thread.run_sync(self.read, link.job_id)
            if state.status in ENDED or time.monotonic() >= deadline:
                return link.model_copy(update={"state": state})
            await asyncio.sleep(LOOK_EVERY_S)

    def read(self, job_id: str) -> JobAnswer:
        """Where a verification stands.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job, or no queue.
        """
        return _job_answer(self.service.queue().state(job_id))

    def newest(self, count: int, before: str | None) -> Page[JobAnswer]:
        """Jobs from the newest on.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job to go on from, or no queue.
        """
        items = [_job_answer(state) for state in self.service.queue().newest(count, before)]
        following = f"/v1/jobs?limit={count}&before={items[-1].id}" if len(items) == count else None
        return Page(items=items, next=following)

    def field(self, job_id: str, name: SolveField) -> bytes:
        """A field of a reference solution, an NPY file.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job or field, or no queue.
        """
        return self.service.queue().field(job_id, name)

    def cancel(self, job_id: str) -> JobAnswer:
        """Cancel a verification, waiting or running.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job, or no queue.
        """
        return _job_answer(self.service.queue().cancel(job_id))

    def reference_mask(self, job_id: str) -> bytes:
        """The reference mask of a finished verification, a PNG file.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job, it has not finished, or no queue.
        """
        return self.service.queue().reference_mask(job_id)


def _job_answer(state: JobState) -> JobAnswer:
    fields = asdict(state)
    reference = fields.pop("reference")
    result = reference and reference | {"mask_url": f"/v1/jobs/{state.id}/mask.png"}
    return JobAnswer.model_validate(fields | {"result": result})
