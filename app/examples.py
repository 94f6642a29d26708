"""The examples of the documentation, from a running service that requires no keys.

`python -m app.examples http://127.0.0.1:8000 > app/examples.json` asks it everything once.
"""

import io
import json
import sys
import time
import zipfile
from typing import Any

import httpx
import numpy as np
from PIL import Image

from solver import random_midpoint_displacement

FIELDS = {
    "load_n": "30",
    "pixel_size_um": "15.625",
    "height_range_um": "50",
    "effective_modulus_gpa": "6.843",
    "resistivity_ohm_m": "1.7e-8",
}
UNKNOWN = "0" * 32

Example = dict[str, Any]


def main() -> None:
    """Print them."""
    with httpx.Client(base_url=sys.argv[1], timeout=120) as client:
        found = {"operations": _operations(client), "problems": _problems(client)}
    print(json.dumps(found, indent=1))


def _operations(client: httpx.Client) -> dict[str, Example]:
    """By operation: fields of the form, parameters of the path, and answers by media type."""
    png = _png(np.rint(random_midpoint_displacement(64, seed=1) * 65535).astype(np.uint16))
    asked = FIELDS | {"outputs": "statistics,resistances,roughness,pressure"}
    wanted = {
        "make_prediction": ("/v1/predictions", asked, "surface", png),
        "sweep": ("/v1/sweeps", _without(FIELDS, "load_n") | {"loads_n": "10,20,40"}, "surface", png),
        "queue_solve": ("/v1/solves", FIELDS | {"outputs": "pressure,gap,statistics"}, "surface", png),
        "predict_batch": ("/v1/batches", FIELDS, "archive", _zip({"first.png": png})),
    }
    operations: dict[str, Example] = {}
    for name, (path, fields, field, data) in wanted.items():
        answer = client.post(path, data=fields, files={field: data})
        operations[name] = {"fields": {field: f"@{path[4:]}"} | fields} | _answer(answer)
    csv = client.post("/v1/sweeps", data=wanted["sweep"][1], files={"surface": png}, headers={"Accept": "text/csv"})
    operations["sweep"]["answers"] |= _answer(csv)["answers"]

    prediction = operations["make_prediction"]["answers"]["application/json"]
    job_id = operations["queue_solve"]["answers"]["application/json"]["job"]["job_id"]
    while client.get(f"/v1/jobs/{job_id}").json()["status"] != "finished":
        time.sleep(0.1)
    for name, path, parameters in (
        ("list_predictions", "/v1/predictions?limit=1", {}),
        ("read_prediction", f"/v1/predictions/{prediction['id']}", {"prediction_id": prediction["id"]}),
        ("list_jobs", "/v1/jobs?limit=1", {}),
        ("read_job", f"/v1/jobs/{job_id}", {"job_id": job_id}),
        ("follow_job", f"/v1/jobs/{job_id}/events", {"job_id": job_id}),
        ("list_models", "/v1/models", {}),
        ("healthz", "/healthz", {}),
        ("readyz", "/readyz", {}),
        ("list_problem_types", "/problems", {}),
        ("read_problem_type", "/problems/colour-png", {"code": "colour-png"}),
    ):
        operations[name] = {"path": parameters} | _answer(client.get(path))
    operations["list_problem_types"]["answers"]["application/json"][2:] = []
    operations["cancel_job"] = {"path": {"job_id": job_id}} | _answer(client.delete(f"/v1/jobs/{job_id}"))
    for name in ("read_mask", "read_bundle"):
        operations[name] = {"path": {"prediction_id": prediction["id"]}}
    for name in ("read_field", "read_picture"):
        operations[name] = {"path": {"prediction_id": prediction["id"], "name": "pressure"}}
    operations["read_reference_mask"] = {"path": {"job_id": job_id}}
    operations["read_reference_field"] = {"path": {"job_id": job_id, "name": "gap"}}
    return operations


def _problems(client: httpx.Client) -> dict[str, Example]:
    """Problem documents that a request can provoke, by code."""
    grey = np.tile(np.arange(64, dtype=np.uint8), (64, 1))
    png = _png(grey)
    answers = [
        client.post("/v1/predictions", data=fields, files={"surface": data})
        for fields, data in (
            (_without(FIELDS, "load_n") | {"poissons_ratio_1": "0.7"}, png),
            (FIELDS, _png(np.zeros((64, 64), np.uint8))),
            (FIELDS, _png(np.stack([grey] * 3, axis=2))),
            (FIELDS, _png(np.stack([grey] * 4, axis=2))),
            (FIELDS, png[:-30]),
            (FIELDS, png[:60] + b"?" + png[61:]),
            (FIELDS, b"no height map"),
            (FIELDS, _png(np.zeros((1, 5000), np.uint8))),
            (FIELDS | {"webhook_url": "http://127.0.0.1/"}, png),
        )
    ]
    answers.append(client.post("/v1/batches", data=FIELDS, files={"archive": b"no archive"}))
    answers.append(client.post("/v1/predictions", content=b"-", headers={"Content-Type": "multipart/form-data; boundary=-"}))
    paths = (f"/v1/predictions/{UNKNOWN}", f"/v1/jobs/{UNKNOWN}", "/v1/nothing")
    answers += [client.get(path) for path in paths]
    answers.append(client.put("/v1/jobs"))
    return {answer.json()["type"].rpartition("/")[2]: answer.json() for answer in answers if answer.is_error}


def _answer(answer: httpx.Response) -> Example:
    """An answer by its media type: as JSON if it is, else as text."""
    answer.raise_for_status()
    media_type = answer.headers["content-type"].partition(";")[0]
    return {"answers": {media_type: answer.json() if media_type == "application/json" else answer.text}}


def _without(fields: dict[str, str], name: str) -> dict[str, str]:
    return {key: value for key, value in fields.items() if key != name}


def _png(values: np.ndarray) -> bytes:
    file = io.BytesIO()
    Image.fromarray(values).save(file, "PNG")
    return file.getvalue()


def _zip(files: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return file.getvalue()


if __name__ == "__main__":
    main()
