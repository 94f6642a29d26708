"""Every kind of problem that the service may answer with, from the one tree of typed errors.

`python -m app.problem_types > docs/problems.md` writes the documentation of the type URIs.
"""

import inspect
from collections.abc import Iterator

from pydantic import BaseModel

from app import errors as app_errors
from model import errors as model_errors
from solver import errors as solver_errors
from solver.errors import AsperityError
from worker import errors as worker_errors

MODULES = (app_errors, worker_errors, model_errors, solver_errors)

HEADER = """# Problems

Every refusal and failure is a problem document (RFC 9457, `application/problem+json`) whose `type` is one of these URIs,
which stay what they are. `detail` says what is wrong with this request and what to change; `errors` says it by field of the
form. GET of such a URI answers with its row of this table.
Written by `python -m app.problem_types > docs/problems.md`.

| type | status | title | when |
|---|---|---|---|
"""


class ProblemType(BaseModel):
    """A kind of problem."""

    type: str
    status: int
    title: str
    when: str


def problem_types() -> list[ProblemType]:
    """All kinds, by their URI."""
    kinds = {kind.code: kind for kind in _kinds()}
    return [
        ProblemType(
            type=f"/problems/{code}",
            status=kind.http_status,
            title=kind.title,
            when=(inspect.getdoc(kind) or "").partition("\n")[0],
        )
        for code, kind in sorted(kinds.items())
    ]


def _kinds() -> Iterator[type[AsperityError]]:
    for module in MODULES:
        for _, kind in inspect.getmembers(module, inspect.isclass):
            if issubclass(kind, AsperityError):
                yield kind


def main() -> None:
    """Print the documentation."""
    rows = [f"| `{kind.type}` | {kind.status} | {kind.title} | {kind.when} |" for kind in problem_types()]
    print(HEADER + "\n".join(rows))


if __name__ == "__main__":
    main()
