"""The type URIs of problems are documented."""

from pathlib import Path

import httpx

from app.problem_types import HEADER, problem_types

DOCUMENT = Path(__file__).parents[2] / "docs/problems.md"


def test_the_document_is_up_to_date() -> None:
    rows = [line for line in DOCUMENT.read_text().splitlines() if line.startswith("| `/problems/")]
    assert DOCUMENT.read_text().startswith(HEADER)
    assert rows == [f"| `{kind.type}` | {kind.status} | {kind.title} | {kind.when} |" for kind in problem_types()]


def test_every_kind_has_a_name_of_its_own_and_a_meaning() -> None:
    kinds = problem_types()
    assert len({kind.title for kind in kinds}) == len(kinds)
    assert all(kind.when.endswith(".") and 400 <= kind.status < 600 for kind in kinds)


def test_a_type_uri_can_be_followed(client: httpx.Client) -> None:
    problem = client.post("/v1/predictions", data={}).json()
    kind = client.get(problem["type"]).json()
    assert (kind["type"], kind["title"], kind["status"]) == (problem["type"], problem["title"], problem["status"])
    assert len(client.get("/problems").json()) == len(problem_types())
    assert client.get("/problems/nonsense").status_code == 404
