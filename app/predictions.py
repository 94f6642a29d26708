"""Predictions: computed once, stored, verified, and read again."""

from base64 import b64encode
from collections.abc import AsyncIterator, Sequence

from app.archive import members
from app.body_limit import MEBIBYTE
from app.content import content_id
from app.errors import IdempotencyKeyReusedError
from app.fields import UNITS, FieldName, bundle, picture
from app.jobs import job_link
from app.prediction import Stopwatch, Wanted, predict
from app.problems import problem_of
from app.reading import Files, read_problem
from app.requests import BatchForm, Output, PredictionFields, PredictionForm
from app.schemas import BatchItem, FieldLink, JobLink, Page, PredictionAnswer
from app.service import Service
from model.prediction import Prediction
from solver import ContactProblem
from solver.errors import AsperityError
from solver.problem import BoolArray
from worker.arrays import Field, from_npy, npy
from worker.errors import JobNotFoundError, ResultNotFoundError
from worker.logs import request_id
from worker.masks import mask_from_png, mask_png
from worker.parcel import Parcel

PREDICTION, MASK = "prediction.json", "mask.png"
"""Files of a stored prediction."""


class Predictions:
    """Predictions of a service."""

    def __init__(self, service: Service) -> None:
        self.service = service

    async def predict(self, files: Files, form: PredictionForm, key: str | None = None) -> tuple[PredictionAnswer, bool]:
        """Predict, store, and queue the verification, away from the event loop.

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
        return await self.service.in_thread(self._predict, files, form, key)

    def _predict(self, files: Files, form: PredictionFields, key: str | None) -> tuple[PredictionAnswer, bool]:
        stopwatch = Stopwatch()
        prediction_id = content_id(files, form, self.service.surrogate.version)
        if key is not None and self.service.store.claim(key, prediction_id) != prediction_id:
            raise IdempotencyKeyReusedError("This idempotency key stands for another request; choose a new one.")
        try:
            answer = self.read(prediction_id)
        except ResultNotFoundError:
            return self._computed(prediction_id, files, form, stopwatch), False
        if form.verify and not (answer.verification and self._lives(answer.verification.job_id)):
            reading = read_problem(files, form, form.load_n, self.service.sandbox.decode)
            answer.verification = self._verified(reading.problem, mask_from_png(self.mask(prediction_id)), form)
            self.service.store.put(prediction_id, {PREDICTION: answer.model_dump_json().encode()})
        return self._delivered(answer, form), True

    def _computed(self, prediction_id: str, files: Files, form: PredictionFields, stopwatch: Stopwatch) -> PredictionAnswer:
        """A prediction that was not there."""
        reading = read_problem(files, form, form.load_n, self.service.sandbox.decode)
        stopwatch.lap("decode")
        wanted = Wanted(form.accuracy, form.resistivity_ohm_m, form.outputs)
        predicted = predict(reading, wanted, self.service.surrogate, stopwatch)
        url = f"/v1/predictions/{prediction_id}"
        mask = predicted.prediction.contact_mask
        fields = _fields(reading.problem, predicted.prediction, form.outputs)
        stored = {MASK: mask_png(mask)} | {f"{name}.npy": npy(values) for name, values in fields.items()}
        stopwatch.lap("encode")
        verification = self._verified(reading.problem, mask, form) if form.verify else None
        if verification:
            stopwatch.lap("queue")
        answer = PredictionAnswer(
            **dict(predicted.numbers) | {"timings_ms": stopwatch.timings_ms},
            id=prediction_id,
            mask_url=f"{url}/{MASK}",
            mask=None,
            fields={name: _link(url, name, values) for name, values in fields.items()},
            bundle_url=f"{url}/bundle.nc",
            verification=verification,
        )
        self.service.metrics.predicted(answer)
        self.service.store.put(prediction_id, stored | {PREDICTION: answer.model_dump_json().encode()})
        return self._delivered(answer, form)

    def _verified(self, problem: ContactProblem, mask: BoolArray, form: PredictionFields) -> JobLink:
        """The verification of a prediction, queued."""
        parcel = Parcel(problem, mask, form.resistivity_ohm_m, model=self.service.surrogate.version)
        return job_link(self.service.queue().enqueue(parcel, None, request_id.get(), form.webhook_url))

    def _lives(self, job_id: str) -> bool:
        """Whether a job has not ended without a result."""
        try:
            return self.service.queue().state(job_id).status not in ("failed", "canceled")
        except JobNotFoundError:
            return False

    def _delivered(self, answer: PredictionAnswer, form: PredictionFields) -> PredictionAnswer:
        """With the mask itself and the link of the verification, as far as they were asked for."""
        mask = b64encode(self.mask(answer.id)).decode() if form.inline_mask else None
        return answer.model_copy(update={"mask": mask, "verification": answer.verification if form.verify else None})

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
        maps = list(members(archive, self.service.settings.upload_limit_mib * MEBIBYTE))
        return self.service.one_by_one(self._batch_item(name, data, form) for name, data in maps)

    def _batch_item(self, name: str, data: bytes, form: BatchForm) -> BatchItem:
        try:
            answer, _ = self._predict(Files(data), form, None)
        except AsperityError as error:
            return BatchItem(file=name, prediction=None, problem=problem_of(error, "/v1/batches"))
        return BatchItem(file=name, prediction=answer, problem=None)

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
        return self.service.store.get(prediction_id, f"{name}.npy")

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


def _fields(problem: ContactProblem, prediction: Prediction, outputs: Sequence[Output]) -> dict[FieldName, Field]:
    """The fields that were asked for."""
    known: dict[FieldName, Field] = {
        "heights": problem.heights,
        "pressure": prediction.pressure,
        "probability": prediction.probability,
    }
    return {name: values for name, values in known.items() if name in outputs}


def _link(url: str, name: FieldName, values: Field) -> FieldLink:
    return FieldLink(
        unit=UNITS[name],
        lowest=float(values.min()),
        highest=float(values.max()),
        npy_url=f"{url}/{name}.npy",
        png_url=f"{url}/{name}.png",
    )
