"""Predictions as the processes compute them: read, predicted, measured, stored, and their verification queued."""

from base64 import b64encode
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from app.compute import Computer
from app.fields import UNITS, FieldName
from app.job_link import job_link
from app.prediction import Stopwatch, Wanted, predict
from app.reading import Maps, Reading, read_problem
from app.requests import Output, PredictionFields
from app.schemas import FieldLink, PredictionAnswer
from model.methods import Accuracy
from model.prediction import Prediction
from solver import ContactProblem
from worker.arrays import Field, npy
from worker.logs import request_id
from worker.masks import mask_png
from worker.parcel import Parcel
from worker.tracing import Carrier, span

Result = TypeVar("Result")

PREDICTION, MASK = "prediction.json", "mask.png"
"""Files of a stored prediction; where the first is, all are."""


def bare(form: PredictionFields) -> PredictionFields:
    """A form without its files."""
    return PredictionFields.model_construct(**{name: getattr(form, name) for name in PredictionFields.model_fields})


@dataclass(frozen=True)
class Item:
    """A prediction that was not there.

    Attributes:
        prediction_id: under which it is stored.
        maps: heights.
        form: what people gave besides.
        request: id of the request.
        place: of the request in a trace.
    """

    prediction_id: str
    maps: Maps
    form: PredictionFields
    request: str | None
    place: Carrier


def computed_predictions(computer: Computer, items: Sequence[Item]) -> list[PredictionAnswer | Exception]:
    """Compute predictions, or say why not; the network is asked once for all that begin with it.

    Each is computed by itself besides, and none suffers from the faults of another.
    """
    readings = [_tried(_read, item) for item in items]
    kinds: dict[tuple[object, ...], list[_Read]] = {}
    for one in readings:
        if isinstance(one, _Read) and _tried(computer.surrogate.begins_with_network, *one.question) is True:
            kinds.setdefault(one.kind, []).append(one)
    estimates: dict[_Read, Prediction] = {}
    for asked in kinds.values():
        if len(asked) > 1:
            found = _tried(computer.surrogate.estimate_batch, [one.reading.problem for one in asked])
            estimates |= {} if isinstance(found, Exception) else dict(zip(asked, found, strict=True))
    return [
        one if isinstance(one, Exception) else _tried(_computed, computer, item, one, estimates.get(one))
        for item, one in zip(items, readings, strict=True)
    ]


@dataclass(frozen=True, eq=False)
class _Read:
    """An item that was read, and the time that took."""

    reading: Reading
    accuracy: Accuracy
    stopwatch: Stopwatch

    @property
    def question(self) -> tuple[ContactProblem, Accuracy]:
        """What is asked of the surrogate."""
        return self.reading.problem, self.accuracy

    @property
    def kind(self) -> tuple[object, ...]:
        """What problems that the network is asked for at once have in common."""
        problem = self.reading.problem
        return problem.shape, problem.pixel_size, problem.boundary


def _read(item: Item) -> _Read:
    stopwatch = Stopwatch()
    reading = read_problem(item.maps, item.form, item.form.load_n)
    stopwatch.lap("decode")
    return _Read(reading, item.form.accuracy, stopwatch)


def _tried(function: Callable[..., Result], *arguments: object) -> Result | Exception:
    try:
        return function(*arguments)
    except Exception as error:  # noqa: BLE001 (raised again in the process that asked)
        return error


def _computed(computer: Computer, item: Item, read: _Read, estimate: Prediction | None) -> PredictionAnswer:
    """Predict, measure, store, and queue the verification."""
    request_id.set(item.request)
    with span("computed_prediction", item.place):
        return _stored(computer, item.prediction_id, item.form, read, estimate)


def _stored(
    computer: Computer, prediction_id: str, form: PredictionFields, read: _Read, estimate: Prediction | None
) -> PredictionAnswer:
    reading, stopwatch = read.reading, read.stopwatch
    wanted = Wanted(form.accuracy, form.resistivity_ohm_m, form.outputs)
    predicted = predict(reading, wanted, computer.surrogate, stopwatch, estimate)
    url, problem = f"/v1/predictions/{prediction_id}", reading.problem
    contact = predicted.prediction.contact_mask
    mask = mask_png(contact)
    fields = _fields(problem, predicted.prediction, form.outputs)
    stored = {MASK: mask} | {f"{name}.npy": npy(values) for name, values in fields.items()}
    stopwatch.lap("encode")
    verification = None
    if form.verify:
        parcel = Parcel(problem, contact, form.resistivity_ohm_m, model=computer.surrogate.version)
        verification = job_link(computer.queue().enqueue(parcel, None, request_id.get(), form.webhook_url))
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
    computer.store.put(prediction_id, stored | {PREDICTION: answer.model_dump_json().encode()})
    return delivered(answer, mask, form)


def delivered(answer: PredictionAnswer, mask: bytes, form: PredictionFields) -> PredictionAnswer:
    """An answer with the mask itself and the link of the verification, as far as they were asked for."""
    inline = b64encode(mask).decode() if form.inline_mask else None
    return answer.model_copy(update={"mask": inline, "verification": answer.verification if form.verify else None})


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
