"""What the HTTP interface takes: forms with files."""

from collections.abc import Callable
from typing import Annotated, Any, Literal, get_args

import numpy as np
from fastapi import UploadFile
from pydantic import BaseModel, ConfigDict, Field, PlainValidator, ValidationInfo, WithJsonSchema, field_validator
from pydantic_core import PydanticCustomError

from app.forms import BodiesForm, PositiveFinite, ProblemForm, choose_one, meaning, parse_accuracy
from app.reading import Files
from model.errors import AccuracyError
from model.methods import Accuracy
from worker.parcel import Output as SolveOutput

Output = Literal["heights", "pressure", "probability", "statistics", "resistances", "roughness"]
OUTPUTS, SOLVE_OUTPUTS = get_args(Output), get_args(SolveOutput)
MOST_LOADS = 200
RANGE = ("load_from_n", "load_to_n", "load_count")

TEXT = WithJsonSchema({"type": "string"})


def _accuracy(value: object) -> Accuracy:
    try:
        return parse_accuracy(value)
    except AccuracyError as error:
        raise ValueError(str(error)) from error


def _from_commas(value: object) -> list[str]:
    """The parts of a list that was given with commas, or again and again."""
    parts = value if isinstance(value, list | tuple) else [value]
    return [name.strip() for part in parts for name in str(part).split(",") if name.strip()]


def _some_of(names: tuple[str, ...]) -> Callable[[object], list[str]]:
    """A validator of lists of names."""

    def validate(value: object) -> list[str]:
        given = _from_commas(value)
        if not set(given) <= set(names):
            raise ValueError
        return given

    return validate


def _loads(value: object) -> list[float] | None:
    if value is None:
        return None
    loads = [float(part) for part in _from_commas(value)]
    if not 0 < len(loads) <= MOST_LOADS or not all(0 < load < np.inf for load in loads):
        raise ValueError
    return loads


def _check_resistivity(value: list[str], info: ValidationInfo) -> list[str]:
    """Resistances need a resistivity."""
    if "resistances" in value and info.data.get("resistivity_ohm_m") is None:
        raise PydanticCustomError("missing", f"resistivity_ohm_m is missing: give the {meaning('resistivity_ohm_m')}.")
    return value


AccuracyField = Annotated[Accuracy, PlainValidator(_accuracy), TEXT]
ACCURACY = (
    "accuracy: 'fast', 'balanced', 'exact', or the mean error that is allowed of 1 - Dice, contact area and contact "
    "resistance, 0 to 1"
)


class JobFields(BaseModel):
    """What is wanted of a job."""

    webhook_url: str | None = Field(None, description="URL that is told, signed, when the reference solve has ended")


class FilesForm(BaseModel):
    """The height maps of a multipart form, which takes no fields but its own."""

    model_config = ConfigDict(extra="forbid")

    surface: UploadFile = Field(description="height map: grey PNG or TIFF (black lowest), NPY, CSV, or an instrument's file")
    surface_2: UploadFile | None = Field(
        None, description="height map of the surface that it touches, of as many pixels; a flat if left out"
    )

    async def files(self) -> Files:
        """The uploaded files."""
        return Files(await self.surface.read(), await self.surface_2.read() if self.surface_2 else None)


class PredictionFields(ProblemForm, JobFields):
    """A contact problem without its height map, and what is wanted of its prediction."""

    accuracy: AccuracyField = Field("balanced", description=ACCURACY)
    verify: bool = Field(True, description="true or false: whether the reference solver checks the prediction")
    inline_mask: bool = Field(False, description="true or false: whether the answer holds the mask itself")
    outputs: Annotated[list[Output], PlainValidator(_some_of(OUTPUTS)), TEXT] = Field(
        [], description=f"names of what else to compute, separated by commas: {', '.join(OUTPUTS)}"
    )

    _resistances = field_validator("outputs")(_check_resistivity)


class PredictionForm(PredictionFields, FilesForm):
    """A contact problem with its height map, as multipart form."""


class BatchForm(PredictionFields):
    """Many height maps under one load, of one material, as multipart form."""

    model_config = ConfigDict(extra="forbid")

    archive: UploadFile = Field(description="zip file of height maps, each as surface would be")
    verify: bool = Field(False, description="true or false: whether the reference solver checks the predictions")


class SolveForm(ProblemForm, FilesForm, JobFields):
    """A contact problem to solve without a prediction."""

    outputs: Annotated[list[SolveOutput], PlainValidator(_some_of(SOLVE_OUTPUTS)), TEXT] = Field(
        [], description=f"names of what else to compute, separated by commas: {', '.join(SOLVE_OUTPUTS)}"
    )

    _resistances = field_validator("outputs")(_check_resistivity)


class SweepForm(BodiesForm, FilesForm):
    """One surface under many loads."""

    load_from_n: PositiveFinite | None = Field(None, description="lightest load of a range, in N")
    load_to_n: PositiveFinite | None = Field(None, description="heaviest load of a range, in N")
    load_count: Annotated[int, Field(ge=1, le=MOST_LOADS)] | None = Field(
        None, description=f"number of loads of a range, 1 to {MOST_LOADS}, evenly spaced on a logarithmic scale"
    )
    loads_n: Annotated[list[float] | None, PlainValidator(_loads), TEXT] = Field(
        None, description=f"loads in N, positive, separated by commas, at most {MOST_LOADS}", validate_default=True
    )
    accuracy: AccuracyField = Field("balanced", description=ACCURACY)

    @field_validator("loads_n")
    @classmethod
    def _some_loads(cls, value: list[float] | None, info: ValidationInfo) -> list[float] | None:
        if not choose_one("loads_n", value, RANGE, info.data):
            raise PydanticCustomError(
                "missing", f"loads_n is missing: give the {cls.model_fields['loads_n'].description}, or {', '.join(RANGE)}."
            )
        return value

    @property
    def loads(self) -> list[float]:
        """All loads, in N."""
        given: dict[str, Any] = {name: getattr(self, name) for name in RANGE}
        return self.loads_n or list(map(float, np.geomspace(*given.values())))
