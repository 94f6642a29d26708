"""What the type URIs of problem documents mean."""

from fastapi import APIRouter, HTTPException

from app.problem_types import ProblemType, problem_types

router = APIRouter(prefix="/problems", tags=["problems"])


@router.get("")
def list_problem_types() -> list[ProblemType]:
    """Every kind of problem that this service answers with."""
    return problem_types()


@router.get("/{code}")
def read_problem_type(code: str) -> ProblemType:
    """The kind of problem with this type URI."""
    for kind in problem_types():
        if kind.type == f"/problems/{code}":
            return kind
    raise HTTPException(404)
