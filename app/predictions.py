"""Predictions: computed once, stored, verified, and read again."""

import time
from collections.abc import AsyncIterator, Awaitable

from pydantic import BaseModel

from app.archive import Archive
from app.computing import MASK, PREDICTION, Item, bare, delivered
from app.content import content_id
from app.errors import BusyError, IdempotencyKeyReusedError, InternalError
from app.fields import FieldName, bundle, picture
from app.intake import MEBIBYTE
from app.job_link import job_link
from app.problem import Problem
from app.problems import RETRY_AFTER_SECONDS, problem_of
from app.reading import Files, Maps, read_problem
from app.requests import BatchForm, PredictionFields
from app.schemas import BatchItem, Page, Pending, PredictionAnswer
from app.service import Service
from solver.errors import AsperityError
from worker.arrays import Field, from_npy
from worker.errors import JobNotFoundError, ResultNotFoundError
from worker.logs import request_id
from worker.masks import mask_from_png
from worker.parcel import Parcel
from worker.tracing import carrier

BEGUN = "begun.json"
LONGEST_PENDING_S = 600.0
"""A prediction that takes longer was lost with its process."""


class Begun(BaseModel):
    """What is known of a prediction that was asked for and may not be there.

    Attributes:
        until: when this is forgotten, in seconds since 1970.
        problem: why there is none; None while it is computed.
    """

    until: float
    problem: Problem | None


class Predictions:
    """Predictions of a service."""

    def __init__(self, service: Service) -> None:
        self.service = service

    async def predict(self, files: Files, form: PredictionFields, key: str | None = None) -> tuple[PredictionAnswer, bool]:
        """Predict, store, and queue the verification.

        The id of a prediction is the hash of all that it depends on, so that what was computed once is only read again.

        Args:
            files: height maps.
            form: what people gave besides files.
            key: an idempotency key.

        Returns:
            The answer, and whether it was there already.

        Raises:
            AsperityError: bad input, an idempotency key that stands for another request, or no queue for a verification.
        """
        service, fields = self.service, bare(form)
        prediction_id, known = await service.in_thread(self._known, files, fields, key)
        if known is not None:
            return known, True
        return await self._compute(prediction_id, files, fields), False

    async def begin(
        self, files: Files, form: PredictionFields, key: str | None
    ) -> tuple[Pending, Awaitable[tuple[PredictionAnswer, bool]]]:
        """As :meth:`predict`, without waiting for what is to be computed.

        Returns:
            Where its outcome will be, and what computes it.

        Raises:
            AsperityError: it cannot be begun.
        """
        service, fields = self.service, bare(form)
        if service.in_background >= service.settings.requests_waiting:
            raise BusyError(f"{service.in_background} requests are computed in the background; try again later.")
        prediction_id, known = await service.in_thread(self._known, files, fields, key)
        pending = Pending(id=prediction_id, url=f"/v1/predictions/{prediction_id}")
        if known is None and form.verify and form.webhook_url is not None:
            await service.in_thread(service.queue().check_webhook, form.webhook_url)
        if known is None:
            await service.in_thread(self._note, prediction_id, None, LONGEST_PENDING_S)
        return pending, service.go_on(self._noted(pending, files, fields, known))

    async def _noted(
        self, pending: Pending, files: Files, fields: PredictionFields, known: PredictionAnswer | None
    ) -> tuple[PredictionAnswer, bool]:
        """Compute what is not known; what goes wrong is kept for whoever asks, if only for a while where it may pass."""
        if known is not None:
            return known, True
        try:
            return await self._compute(pending.id, files, fields), False
        except Exception as error:
            problem = problem_of(error if isinstance(error, AsperityError) else InternalError(), pending.url)
            keep_s = RETRY_AFTER_SECONDS if problem.status >= 500 else self.service.settings.retention_s
            await self.service.in_thread(self._note, pending.id, problem, keep_s)
            raise

    def _note(self, prediction_id: str, problem: Problem | None, keep_s: float) -> None:
        begun = Begun(until=time.time() + keep_s, problem=problem)
        self.service.store.put(prediction_id, {BEGUN: begun.model_dump_json().encode()})

    async def _compute(self, prediction_id: str, files: Files, fields: PredictionFields) -> PredictionAnswer:
        maps = await self.service.in_thread(Maps.of, files, self.service.sandbox.decode)
        answer = await self.service.batching.predict(Item(prediction_id, maps, fields, request_id.get(), carrier()))
        self.service.metrics.predicted(answer)
        return answer

    def outcome(self, prediction_id: str) -> PredictionAnswer | Pending | Problem:
        """What has become of a prediction.

        Raises:
            ResultNotFoundError: there is none of that id.
        """
        try:
            return self.read(prediction_id)
        except ResultNotFoundError:
            begun = Begun.model_validate_json(self.service.store.get(prediction_id, BEGUN))
            if time.time() > begun.until:
                raise
            return begun.problem or Pending(id=prediction_id, url=f"/v1/predictions/{prediction_id}")

    def _known(self, files: Files, form: PredictionFields, key: str | None) -> tuple[str, PredictionAnswer | None]:
        """Its id, and the answer that is there, verified now if that was not asked for before; None if there is none."""
        prediction_id = content_id(files, form, self.service.version)
        if key is not None and self.service.store.claim(key, prediction_id) != prediction_id:
            raise IdempotencyKeyReusedError("This idempotency key stands for another request; choose a new one.")
        try:
            answer = self.read(prediction_id)
        except ResultNotFoundError:
            return prediction_id, None
        told = form.webhook_url is not None and key is None  # by a job of its own, for the one that is there tells others
        if form.verify and (told or not (answer.verification and self._lives(answer.verification.job_id))):
            reading = read_problem(files, form, form.load_n, self.service.sandbox.decode)
            parcel = Parcel(
                reading.problem, mask_from_png(self.mask(prediction_id)), form.resistivity_ohm_m, model=answer.model
            )
            job_id = self.service.queue().enqueue(parcel, None, request_id.get(), form.webhook_url)
            answer.verification = job_link(job_id)
            self.service.store.put(prediction_id, {PREDICTION: answer.model_dump_json().encode()})
        return prediction_id, delivered(answer, self.mask(prediction_id), form)

    def _lives(self, job_id: str) -> bool:
        """Whether a job has not ended without a result."""
        try:
            return self.service.queue().state(job_id).status not in ("failed", "canceled")
        except JobNotFoundError:
            return False

    def newest(self, count: int, before: str | None) -> Page[PredictionAnswer]:
        """Stored predictions from the newest on.

        Raises:
            ResultNotFoundError: there is no such prediction to go on from.
        """
        items = [self.read(one) for one in self.service.store.newest(MASK, count, before)]
        following = f"/v1/predictions?limit={count}&before={items[-1].id}" if len(items) == count else None
        return Page(items=items, next=following)

    async def batch(self, archive: bytes, form: BatchForm) -> AsyncIterator[BatchItem]:
        """Predict for all height maps of an archive; one that fails says why, and the others go on.

        Raises:
            ArchiveError: the archive cannot be read.
        """
        limit = self.service.settings.upload_limit_mib * MEBIBYTE
        return self._items(await self.service.in_thread(Archive, archive, limit), form)

    async def _items(self, archive: Archive, form: BatchForm) -> AsyncIterator[BatchItem]:
        for info in archive.files:
            try:
                answer, _ = await self.predict(Files(await self.service.in_thread(archive.read, info)), form)
            except AsperityError as error:
                yield BatchItem(file=info.filename, prediction=None, problem=problem_of(error, "/v1/batches"))
            else:
                yield BatchItem(file=info.filename, prediction=answer, problem=None)

    def read(self, prediction_id: str) -> PredictionAnswer:
        """A stored prediction, as it was answered.

        Raises:
            ResultNotFoundError: there is none of that id.
        """
        return PredictionAnswer.model_validate_json(self.service.store.get(prediction_id, PREDICTION))

    def mask(self, prediction_id: str) -> bytes:
        """The mask of a stored prediction, a PNG file.

        Raises:
            ResultNotFoundError: there is none of that id.
        """
        return self.service.store.get(prediction_id, MASK)

    def field_npy(self, prediction_id: str, name: FieldName) -> bytes:
        """A field of a stored prediction, an NPY file.

        Raises:
            ResultNotFoundError: there is none of that id, or the field was not asked for.
        """
        try:
            return self.service.store.get(prediction_id, f"{name}.npy")
        except ResultNotFoundError as error:
            self.read(prediction_id)
            raise ResultNotFoundError(f"The prediction has no {name}; ask for it with outputs={name}.") from error

    def field_png(self, prediction_id: str, name: FieldName) -> bytes:
        """The same as a 16-bit PNG file.

        Raises:
            ResultNotFoundError: there is none of that id, or the field was not asked for.
        """
        return picture(from_npy(self.field_npy(prediction_id, name)))

    def bundle(self, prediction_id: str) -> bytes:
        """The mask and all stored fields of a prediction, a netCDF file.

        Raises:
            ResultNotFoundError: there is none of that id.
        """
        answer = self.read(prediction_id)
        fields: dict[str, Field] = {"contact_mask": mask_from_png(self.mask(prediction_id))}
        fields |= {name: from_npy(self.field_npy(prediction_id, name)) for name in answer.fields}
        surface = answer.surface
        about = {"title": "Contact predicted by Asperity", "prediction": answer.id, "model": answer.model}
        return bundle(fields, (surface.pixel_size_y_um * 1e-6, surface.pixel_size_x_um * 1e-6), about)
