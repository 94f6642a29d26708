"""What the endpoints do: predict, store, queue, and read again."""

from base64 import b64encode
from collections.abc import AsyncIterator, Iterator, Sequence
from dataclasses import asdict

from anyio import CapacityLimiter, to_thread

from app.content import content_id
from app.errors import IdempotencyKeyReusedError
from app.fields import UNITS, FieldName, bundle, picture
from app.metrics import Metrics
from app.prediction import Stopwatch, Wanted, predict
from app.reading import Files, read_problem
from app.requests import Output, PredictionForm, SolveForm, SweepForm
from app.sandbox import Sandbox
from app.schemas import (
    FieldLink,
    JobAnswer,
    JobLink,
    ModelAnswer,
    Page,
    PredictionAnswer,
    SolveAnswer,
    SweepAnswer,
    SweepPoint,
)
from app.settings import Settings
from app.sweep import sweep_points
from model import Surrogate
from model.errors import WeightsError
from model.prediction import Prediction
from model.weights import NAME
from solver import ContactProblem
from solver.problem import BoolArray
from worker.arrays import Field, from_npy, npy
from worker.connection import connect
from worker.errors import JobNotFoundError, ResultNotFoundError
from worker.jobs import JobState, VerificationQueue
from worker.logs import request_id
from worker.masks import mask_from_png, mask_png
from worker.parcel import FieldName as SolveField
from worker.parcel import Parcel
from worker.store import ResultStore, new_id

PREDICTION, MASK = "prediction.json", "mask.png"
"""Files of a stored prediction."""

PREDICTIONS_AT_ONCE = 2
"""More would only share the processors, and memory is what large maps need most."""


class Service:
    """Surrogate, store and queue behind the HTTP interface.

    Without weights it starts all the same: every use of the surrogate then says what is missing.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.store = ResultStore(settings.state_path / "results", settings.retention_s)
        self.metrics = Metrics(self._queue)
        self._limiter = CapacityLimiter(PREDICTIONS_AT_ONCE)
        self._sandbox = Sandbox()
        self._surrogate: Surrogate | WeightsError = WeightsError("The service has not started yet.")

    def start(self) -> None:
        """Load the network, and have the readers of files imported meanwhile."""
        self._sandbox.start()
        try:
            self._surrogate = Surrogate.load()
        except WeightsError as error:
            self._surrogate = error

    @property
    def surrogate(self) -> Surrogate:
        """The surrogate.

        Raises:
            WeightsError: its weights are missing or damaged.
        """
        if isinstance(self._surrogate, WeightsError):
            raise self._surrogate
        return self._surrogate

    def check(self) -> None:
        """Make sure that predictions and verifications are possible.

        Raises:
            WeightsError, QueueUnavailableError: the cause why they are not.
        """
        _ = self.surrogate
        self._queue()

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
        return await to_thread.run_sync(self._predict, files, form, key, limiter=self._limiter)

    def _predict(self, files: Files, form: PredictionForm, key: str | None) -> tuple[PredictionAnswer, bool]:
        stopwatch = Stopwatch()
        prediction_id = content_id(files, form, self.surrogate.version)
        if key is not None and self.store.claim(key, prediction_id) != prediction_id:
            raise IdempotencyKeyReusedError("This idempotency key stands for another request; choose a new one.")
        try:
            answer = self.prediction(prediction_id)
        except ResultNotFoundError:
            return self._computed(prediction_id, files, form, stopwatch), False
        if form.verify and not (answer.verification and self._lives(answer.verification.job_id)):
            reading = read_problem(files, form, form.load_n, self._sandbox.decode)
            answer.verification = self._verified(reading.problem, mask_from_png(self.mask(prediction_id)), form)
            self.store.replace(prediction_id, PREDICTION, answer.model_dump_json().encode())
        return self._with_mask(answer, form), True

    def _computed(self, prediction_id: str, files: Files, form: PredictionForm, stopwatch: Stopwatch) -> PredictionAnswer:
        """A prediction that was not there."""
        reading = read_problem(files, form, form.load_n, self._sandbox.decode)
        stopwatch.lap("decode")
        wanted = Wanted(form.accuracy, form.resistivity_ohm_m, form.outputs)
        predicted = predict(reading, wanted, self.surrogate, stopwatch)
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
        self.metrics.predicted(answer)
        self.store.put(prediction_id, stored | {PREDICTION: answer.model_dump_json().encode()})
        return self._with_mask(answer, form)

    def _verified(self, problem: ContactProblem, mask: BoolArray, form: PredictionForm) -> JobLink:
        """The verification of a prediction, queued."""
        parcel = Parcel(problem, mask, form.resistivity_ohm_m, model=self.surrogate.version)
        return _job_link(self._queue().enqueue(parcel, request_id=request_id.get()))

    def _lives(self, job_id: str) -> bool:
        """Whether a job has not ended without a result."""
        try:
            return self._queue().state(job_id).status not in ("failed", "canceled")
        except JobNotFoundError:
            return False

    def _with_mask(self, answer: PredictionAnswer, form: PredictionForm) -> PredictionAnswer:
        """With the mask itself, if it was asked for."""
        if not form.inline_mask:
            return answer
        return answer.model_copy(update={"mask": b64encode(self.mask(answer.id)).decode()})

    def predictions(self, count: int, before: str | None) -> Page[PredictionAnswer]:
        """Stored predictions from the newest on.

        Raises:
            ResultNotFoundError: there is no such prediction to go on from.
        """
        items = [self.prediction(one) for one in self.store.newest(MASK, count, before)]
        following = f"/v1/predictions?limit={count}&before={items[-1].id}" if len(items) == count else None
        return Page(items=items, next=following)

    def model(self) -> ModelAnswer:
        """The surrogate: what it was trained on and how wrong it was found to be.

        Raises:
            WeightsError: its weights are missing or damaged.
        """
        weights = self.surrogate.weights
        return ModelAnswer(
            name=NAME,
            version=weights.version,
            sha256=weights.manifest["sha256"],
            domain=weights.manifest["domain"],
            measured_error=weights.manifest["validation"],
        )

    async def solve(self, files: Files, form: SolveForm, key: str | None) -> SolveAnswer:
        """Queue a reference solve; for an idempotency key once only.

        Raises:
            AsperityError: bad input, an idempotency key that stands for another request, or no queue.
        """
        return await to_thread.run_sync(self._solve, files, form, key, limiter=self._limiter)

    def _solve(self, files: Files, form: SolveForm, key: str | None) -> SolveAnswer:
        reading = read_problem(files, form, form.load_n, self._sandbox.decode)
        parcel = Parcel(reading.problem, resistivity=form.resistivity_ohm_m, outputs=tuple(form.outputs))
        job_id = new_id()
        if key is not None:
            content = content_id(files, form, "solve")
            claimed, _, first = self.store.claim(key, f"{content} {job_id}").partition(" ")
            if claimed != content:
                raise IdempotencyKeyReusedError("This idempotency key stands for another request; choose a new one.")
            if first != job_id:
                return SolveAnswer(job=_job_link(first), surface=reading.surface, warnings=reading.warnings)
        self._queue().enqueue(parcel, job_id, request_id.get())
        return SolveAnswer(job=_job_link(job_id), surface=reading.surface, warnings=reading.warnings)

    async def sweep(self, files: Files, form: SweepForm) -> tuple[SweepAnswer, AsyncIterator[SweepPoint]]:
        """Predict for many loads.

        Returns:
            The answer without its points, and the points as they are computed.

        Raises:
            AsperityError: bad input.
        """
        load = form.loads[0]
        reading = await to_thread.run_sync(read_problem, files, form, load, self._sandbox.decode, limiter=self._limiter)
        surrogate = self.surrogate
        points = sweep_points(surrogate, reading.problem, form)
        answer = SweepAnswer(model=surrogate.version, surface=reading.surface, warnings=reading.warnings, points=[])
        return answer, self._one_by_one(points)

    async def _one_by_one(self, points: Iterator[SweepPoint]) -> AsyncIterator[SweepPoint]:
        """Each computed away from the event loop, so that other requests come in between."""
        while (point := await to_thread.run_sync(next, points, None, limiter=self._limiter)) is not None:
            yield point

    def prediction(self, prediction_id: str) -> PredictionAnswer:
        """A stored prediction, as it was answered.

        Raises:
            ResultNotFoundError: there is none of that id.
        """
        return PredictionAnswer.model_validate_json(self.store.get(prediction_id, PREDICTION))

    def mask(self, prediction_id: str) -> bytes:
        """The mask of a stored prediction, a PNG file.

        Raises:
            ResultNotFoundError: there is none of that id.
        """
        return self.store.get(prediction_id, MASK)

    def field_npy(self, prediction_id: str, name: FieldName) -> bytes:
        """A field of a stored prediction, an NPY file.

        Raises:
            ResultNotFoundError: there is none of that id, or the field was not asked for.
        """
        return self.store.get(prediction_id, f"{name}.npy")

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
        answer = self.prediction(prediction_id)
        fields: dict[str, Field] = {"contact_mask": mask_from_png(self.mask(prediction_id))}
        fields |= {name: from_npy(self.field_npy(prediction_id, name)) for name in answer.fields}
        surface = answer.surface
        about = {"title": "Contact predicted by Asperity", "prediction": answer.id, "model": answer.model}
        return bundle(fields, (surface.pixel_size_y_um * 1e-6, surface.pixel_size_x_um * 1e-6), about)

    def job(self, job_id: str) -> JobAnswer:
        """Where a verification stands.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job, or no queue.
        """
        return _job_answer(self._queue().state(job_id))

    def jobs(self, count: int, before: str | None) -> Page[JobAnswer]:
        """Jobs from the newest on.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job to go on from, or no queue.
        """
        items = [_job_answer(state) for state in self._queue().newest(count, before)]
        following = f"/v1/jobs?limit={count}&before={items[-1].id}" if len(items) == count else None
        return Page(items=items, next=following)

    def job_field(self, job_id: str, name: SolveField) -> bytes:
        """A field of a reference solution, an NPY file.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job or field, or no queue.
        """
        return self._queue().field(job_id, name)

    def cancel(self, job_id: str) -> JobAnswer:
        """Cancel a verification, waiting or running.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job, or no queue.
        """
        return _job_answer(self._queue().cancel(job_id))

    def reference_mask(self, job_id: str) -> bytes:
        """The reference mask of a finished verification, a PNG file.

        Raises:
            JobNotFoundError, QueueUnavailableError: there is no such job, it has not finished, or no queue.
        """
        return self._queue().reference_mask(job_id)

    def _queue(self) -> VerificationQueue:
        """The queue, over a connection that has just answered: a Redis that restarts is found again."""
        return VerificationQueue(connect(self.settings), self.settings)


def _job_link(job_id: str) -> JobLink:
    url = f"/v1/jobs/{job_id}"
    return JobLink(job_id=job_id, url=url, events_url=f"{url}/events")


def _job_answer(state: JobState) -> JobAnswer:
    fields = asdict(state)
    reference = fields.pop("reference")
    result = reference and reference | {"mask_url": f"/v1/jobs/{state.id}/mask.png"}
    return JobAnswer.model_validate(fields | {"result": result})


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
