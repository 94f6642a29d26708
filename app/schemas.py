"""What the HTTP interface takes and answers."""

from typing import Annotated, Literal, cast, get_args

from fastapi import UploadFile
from pydantic import BaseModel, Field, PlainValidator, ValidationInfo, WithJsonSchema, field_validator
from pydantic_core import PydanticCustomError

from app.fields import FieldName
from app.forms import ProblemForm, meaning, parse_accuracy
from app.reading import Files
from app.statistics import Resistances, RoughnessParameters, Statistics
from app.surface import Surface
from model.errors import AccuracyError
from model.methods import Accuracy

Output = Literal["heights", "pressure", "probability", "statistics", "resistances", "roughness"]


def _accuracy(value: object) -> Accuracy:
    try:
        return parse_accuracy(value)
    except AccuracyError as error:
        raise ValueError(str(error)) from error


def _outputs(value: object) -> tuple[Output, ...]:
    """From names separated by commas, or given again and again."""
    parts = value if isinstance(value, list | tuple) else [value]
    names = [name.strip() for part in parts for name in str(part).split(",") if name.strip()]
    for name in names:
        if name not in get_args(Output):
            raise ValueError(name)
    return tuple(cast(list[Output], names))


class FilesForm(BaseModel):
    """The height maps of a multipart form."""

    surface: UploadFile = Field(description="height map: grey PNG or TIFF (black lowest), NPY, CSV, or an instrument's file")
    surface_2: UploadFile | None = Field(
        None, description="height map of the surface that it touches, of as many pixels; a flat if left out"
    )

    async def files(self) -> Files:
        """The uploaded files."""
        return Files(await self.surface.read(), await self.surface_2.read() if self.surface_2 else None)


class PredictionForm(ProblemForm, FilesForm):
    """A contact problem with its height map, as multipart form."""

    accuracy: Annotated[Accuracy, PlainValidator(_accuracy), WithJsonSchema({"type": "string"})] = Field(
        "balanced",
        description="accuracy: 'fast', 'balanced', 'exact', or the mean error that is allowed of 1 - Dice, contact area and "
        "contact resistance, 0 to 1",
    )
    verify: bool = Field(True, description="true or false: whether the reference solver checks the prediction")
    inline_mask: bool = Field(False, description="true or false: whether the answer holds the mask itself")
    outputs: Annotated[tuple[Output, ...], PlainValidator(_outputs), WithJsonSchema({"type": "string"})] = Field(
        (),
        description=f"names of what else to compute, separated by commas: {', '.join(get_args(Output))}",
        validate_default=False,
    )

    @field_validator("outputs")
    @classmethod
    def _resistances_need_a_resistivity(cls, value: tuple[Output, ...], info: ValidationInfo) -> tuple[Output, ...]:
        if "resistances" in value and info.data.get("resistivity_ohm_m") is None:
            raise PydanticCustomError("missing", f"resistivity_ohm_m is missing: give the {meaning('resistivity_ohm_m')}.")
        return value


class ExpectedError(BaseModel):
    """Errors to be expected of a prediction, all relative: their means, and bounds that nine in ten stay below."""

    dice: float = Field(description="1 - Dice of the mask")
    contact_area: float
    contact_resistance: float
    dice_bound: float
    contact_area_bound: float
    contact_resistance_bound: float


class Numbers(BaseModel):
    """What is predicted of a contact, but for the mask."""

    method: str = Field(description="'surrogate', 'surrogate and solver', or 'solver': the cheapest that is accurate")
    model: str = Field(description="version of the surrogate")
    contact_area_mm2: float = Field(description="real area of contact")
    contact_fraction: float = Field(description="real area of contact / nominal area")
    contact_resistance_ohm: float | None = Field(description="null without a resistivity")
    expected_error: ExpectedError
    in_distribution: bool = Field(description="whether the surrogate was trained on such problems; the warnings say why not")
    statistics: Statistics | None = Field(description="null unless asked for by outputs, as the two below")
    resistances: Resistances | None
    roughness: RoughnessParameters | None
    surface: Surface
    warnings: list[str]
    timings_ms: dict[str, float] = Field(description="by stage, and their total")


class VerificationLink(BaseModel):
    """Where the verification of a prediction can be followed."""

    job_id: str
    url: str


class FieldLink(BaseModel):
    """A field asked for by outputs, as files; in the PNG black is `lowest` and white `highest`."""

    unit: str
    lowest: float
    highest: float
    npy_url: str
    png_url: str


class PredictionAnswer(Numbers):
    """A stored prediction."""

    id: str
    mask_url: str = Field(description="1-bit PNG, white in contact, rows and columns as uploaded")
    mask: str | None = Field(description="the same PNG in base64, if asked for by inline_mask")
    fields: dict[FieldName, FieldLink] = Field(description="by name")
    bundle_url: str = Field(description="netCDF file with the mask and the fields, a unit on each")
    verification: VerificationLink | None


class Progress(BaseModel):
    """How far the reference solve is."""

    iteration: int
    residual: float


class ReferenceAnswer(BaseModel):
    """The reference solution, but for its fields."""

    contact_area_mm2: float
    contact_fraction: float
    contact_resistance_ohm: float | None
    status: str = Field(description="how the solve ended, for people")
    converged: bool
    residual: float
    iterations: int
    solve_seconds: float
    mask_url: str = Field(description="1-bit PNG of the reference mask")


class ComparisonAnswer(BaseModel):
    """Agreement of a prediction with its reference."""

    dice: float
    jaccard: float
    bf_score: float = Field(description="boundary F1 score, tolerance 2 pixels")
    pixel_accuracy: float
    area_error: float = Field(description="predicted / reference - 1")
    resistance_error: float | None = Field(description="predicted / reference - 1; null without a resistivity")


class JobAnswer(BaseModel):
    """A verification job."""

    id: str
    status: Literal["queued", "started", "finished", "failed", "canceled"]
    progress: Progress | None
    result: ReferenceAnswer | None
    comparison: ComparisonAnswer | None
    error: str | None = Field(description="why a failed job failed")
