"""The OpenAPI document, and that the service does what it says."""

from typing import Any

import httpx
import jsonschema
import pytest

from benchmarks.schema import explored

BINARY = {"image/png", "application/x-npy", "application/x-netcdf", "text/plain"}

Document = dict[str, Any]


@pytest.fixture(scope="module")
def document(client: httpx.Client) -> Document:
    found: Document = client.get("/openapi.json").json()
    return found


def operations(document: Document) -> dict[str, Document]:
    return {one["operationId"]: one for path in document["paths"].values() for one in path.values()}


def assert_fits(document: Document, example: object, schema: Document) -> None:
    jsonschema.Draft202012Validator(schema | {"components": document["components"]}).validate(example)


def test_every_answer_has_an_example_that_fits_its_schema(document: Document) -> None:
    for name, operation in operations(document).items():
        successes = [response for status, response in operation["responses"].items() if status.startswith("2")]
        answers = [answer for success in successes for answer in success["content"].items()]
        assert answers, name
        for media_type, answer in answers:
            assert media_type in BINARY or "example" in answer, (name, media_type)
            if media_type == "application/json":
                assert_fits(document, answer["example"], answer["schema"])


def test_every_request_has_an_example(document: Document) -> None:
    for name, operation in operations(document).items():
        for parameter in operation.get("parameters", []):
            assert parameter["in"] != "path" or parameter["example"], name
        if "requestBody" in operation:
            fields = operation["requestBody"]["content"]["multipart/form-data"]["example"]
            schema = operation["requestBody"]["content"]["multipart/form-data"]["schema"]
            form = document["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
            assert set(form["required"]) <= set(fields) <= set(form["properties"]), name


def test_every_problem_of_a_route_has_an_example(document: Document) -> None:
    for name, operation in operations(document).items():
        for status, response in operation["responses"].items():
            if status.isdecimal() and int(status) >= 400:
                problems = response["content"]["application/problem+json"]["examples"]
                assert problems, (name, status)
                for code, problem in problems.items():
                    assert_fits(document, problem["value"], {"$ref": "#/components/schemas/Problem"})
                    assert problem["value"]["type"] == f"/problems/{code}"
                    assert problem["value"]["status"] == int(status)


def test_the_service_does_what_it_says(server: str) -> None:
    done = explored(server, 5)
    assert done.returncode == 0, done.stdout
