"""The one shape of every refusal and failure (RFC 9457)."""

from pydantic import BaseModel, Field

MEDIA_TYPE = "application/problem+json"


class FieldProblem(BaseModel):
    """What is wrong with one field of the request."""

    field: str
    code: str
    detail: str


class Problem(BaseModel):
    """A problem document."""

    type: str = Field(description="stable URI of the kind of problem, /problems/<code>")
    title: str
    status: int
    detail: str = Field(description="what is wrong and what to change")
    instance: str = Field(description="path of the request")
    errors: list[FieldProblem] = Field(description="the same by field, where fields of the request are concerned")
