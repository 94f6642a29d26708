"""What /openapi.json says besides the code: an example of every request and answer, and the problems of every route."""

import inspect
import json
from collections.abc import Iterator
from functools import cache
from http import HTTPStatus
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from starlette.routing import compile_path

from app.problem import MEDIA_TYPE, Problem
from solver.errors import AsperityError

EXAMPLES = Path(__file__).with_name("examples.json")
"""Requests and answers of a running service by operation, and problem documents by their code; see ``app.examples``."""

NPY, NETCDF, PNG = "application/x-npy", "application/x-netcdf", "image/png"

PROBLEM = {"$ref": "#/components/schemas/Problem"}

Responses = dict[int | str, dict[str, Any]]


@cache
def examples() -> dict[str, dict[str, Any]]:
    """``operations`` and ``problems``."""
    found: dict[str, dict[str, Any]] = json.loads(EXAMPLES.read_text(encoding="utf-8"))
    return found


def problems(*kinds: type[AsperityError]) -> Responses:
    """The ``responses`` of a route that may meet these errors, and all that descend from them."""
    responses: Responses = {}
    for kind in sorted(set(_family(kinds)), key=lambda each: each.code):
        status = HTTPStatus(kind.http_status)
        content = {"schema": PROBLEM, "examples": {}}
        response = responses.setdefault(int(status), {"description": status.phrase, "content": {MEDIA_TYPE: content}})
        response["content"][MEDIA_TYPE]["examples"][kind.code] = {"summary": kind.title, "value": _example(kind)}
    return responses


def link(operation: str, parameter: str, pointer: str) -> dict[str, Any]:
    """A link from an answer: the operation whose parameter is at this place of the answer."""
    return {"operationId": operation, "parameters": {parameter: f"$response.body#{pointer}"}}


def file(media_type: str, kind: str = "binary") -> Responses:
    """The ``responses`` of a route that answers with a file."""
    schema = {"type": "string"} if kind == "string" else {"type": "string", "format": kind}
    return {200: {"content": {media_type: {"schema": schema}}}}


def _family(kinds: tuple[type[AsperityError], ...]) -> Iterator[type[AsperityError]]:
    for kind in kinds:
        yield kind
        yield from _family(tuple(kind.__subclasses__()))


def _example(kind: type[AsperityError]) -> dict[str, Any]:
    """A problem document as it was met, or else what its kind means."""
    when = (inspect.getdoc(kind) or "").partition("\n")[0]
    plain = Problem(
        type=f"/problems/{kind.code}", title=kind.title, status=kind.http_status, detail=when, instance="/v1/...", errors=[]
    )
    met: dict[str, Any] = examples()["problems"].get(kind.code, plain.model_dump())
    return met


class Documented(FastAPI):
    """An application whose OpenAPI document has examples."""

    def openapi(self) -> dict[str, Any]:
        """The document, made once."""
        if self.openapi_schema is None:
            document = super().openapi()
            for path in document["paths"].values():
                for operation in path.values():
                    _fill(operation, examples()["operations"].get(operation["operationId"], {}))
            for name, schema in document["components"]["schemas"].items():
                if name.endswith("Form"):
                    _without_null(schema)
        assert self.openapi_schema is not None  # noqa: S101 (made by the line above)
        return self.openapi_schema

    def methods(self, path: str) -> str:
        """The methods that a path has, as the header Allow lists them; empty for a path that is not documented."""
        for template, operations in self.openapi()["paths"].items():
            if compile_path(template)[0].match(path):
                return ", ".join(sorted(map(str.upper, operations)))
        return ""


def _without_null(form: dict[str, Any]) -> None:
    """A field of a form is left out; it cannot be null."""
    for field in form["properties"].values():
        kinds = [kind for kind in field.get("anyOf", []) if kind != {"type": "null"}]
        if len(kinds) == 1:
            del field["anyOf"]
            field |= kinds[0]


def _fill(operation: dict[str, Any], example: dict[str, Any]) -> None:
    """Put the examples of an operation where OpenAPI has them."""
    if "fields" in example:
        operation["requestBody"]["content"]["multipart/form-data"]["example"] = example["fields"]
    for parameter in operation.get("parameters", []):
        if parameter["name"] in example.get("path", {}):
            parameter["example"] = example["path"][parameter["name"]]
    for media_type, answer in example.get("answers", {}).items():
        success = next(response for status, response in operation["responses"].items() if status.startswith("2"))
        success["content"].setdefault(media_type, {})["example"] = answer
