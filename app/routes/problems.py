"""What the type URIs of problem documents mean."""

from fastapi import APIRouter

from app.documentation import problems
from app.errors import NotFoundError
from app.problem_types import ProblemType, problem_types

router = APIRouter(prefix="/problems", tags=["problems"])


@router.get("")
def list_problem_types() -> list[ProblemType]:
    """Every kind of problem that this service answers with."""
    return problem_types()


@router.get("/{code}", responses=problems(NotFoundError))
def read_problem_type(code: str) -> ProblemType:
    """The kind of problem with this type URI."""
    for kind in problem_types():
        if kind.type == f"/problems/{code}":
            return kind
    raise NotFoundError(f"There is no problem {code}; /problems lists what there is.")
