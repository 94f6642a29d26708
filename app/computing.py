"""Predictions as the processes compute them: read, predicted, measured, stored, and their verification queued."""

from base64 import b64encode
from collections.abc import Sequence

from app.compute import Computer
from app.fields import UNITS, FieldName
from app.job_link import job_link
from app.prediction import Stopwatch, Wanted, predict
from app.reading import Maps, read_problem
from app.requests import Output, PredictionFields
from app.schemas import FieldLink, PredictionAnswer
from model.prediction import Prediction
from solver import ContactProblem
from worker.arrays import Field, npy
from worker.logs import request_id
from worker.masks import mask_png
from worker.parcel import Parcel

PREDICTION, MASK = "prediction.json", "mask.png"
"""Files of a stored prediction; where the first is, all are."""


def bare(form: PredictionFields) -> PredictionFields:
    """A form without its files."""
    return PredictionFields.model_construct(**{name: getattr(form, name) for name in PredictionFields.model_fields})


def computed_prediction(computer: Computer, prediction_id: str, maps: Maps, form: PredictionFields) -> PredictionAnswer:
    """A prediction that was not there.

    Raises:
        AsperityError: bad input, a solve that was needed and did not converge, or no queue for a verification.
    """
    stopwatch = Stopwatch()
    reading = read_problem(maps, form, form.load_n)
    stopwatch.lap("decode")
    wanted = Wanted(form.accuracy, form.resistivity_ohm_m, form.outputs)
    predicted = predict(reading, wanted, computer.surrogate, stopwatch)
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
