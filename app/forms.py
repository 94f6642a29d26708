"""The fields of a contact problem as people give them, with the unit in the name; shared by HTTP and command line."""

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Annotated, Any, Self, cast

from pydantic import (
    BaseModel,
    Field,
    FiniteFloat,
    PlainValidator,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)
from pydantic_core import PydanticCustomError

from app.errors import FieldError, InvalidFormError
from app.preparation import Crop, Detrend
from model.methods import Accuracy, target_of
from solver.problem import Boundary

PositiveFinite = Annotated[FiniteFloat, Field(gt=0)]
YoungsModulus = Annotated[float, Field(gt=0)]
PoissonsRatio = Annotated[FiniteFloat, Field(gt=-1, le=0.5)]

BODIES = ("youngs_modulus_1_gpa", "poissons_ratio_1", "youngs_modulus_2_gpa", "poissons_ratio_2")


def _crop(value: object) -> Crop:
    """From four whole numbers, none negative and the last two positive."""
    numbers = [int(part) for part in str(value).split(",")]
    if len(numbers) != 4 or min(numbers) < 0 or min(numbers[2:]) == 0:
        raise ValueError
    return Crop(*numbers)


class BodiesForm(BaseModel):
    """Units and material of two bodies; every description completes the sentence "give the ..."."""

    pixel_size_x_um: PositiveFinite | None = Field(
        None, description="distance between neighbouring columns, in micrometres, where pixels are not square"
    )
    pixel_size_y_um: PositiveFinite | None = Field(
        None, description="distance between neighbouring rows, in micrometres, where pixels are not square"
    )
    pixel_size_um: PositiveFinite | None = Field(
        None, description="distance between neighbouring pixels, in micrometres", validate_default=True
    )
    height_range_um: PositiveFinite | None = Field(
        None,
        description="height from black (code 0, lowest) to white (code 255 or 65535, highest), in micrometres, of an image",
    )
    height_unit_um: PositiveFinite | None = Field(
        None, description="height that a value of 1 stands for, in micrometres; for files of numbers that do not hold it"
    )
    height_range_2_um: PositiveFinite | None = Field(
        None, description="height from black to white of the second surface, in micrometres, if it is an image"
    )
    crop: Annotated[Crop | None, PlainValidator(_crop), WithJsonSchema({"type": "string"})] = Field(
        None, description="part of the map to press on: first row, first column, rows, columns, separated by commas"
    )
    detrend: Detrend = Field(
        "none", description="trend to take from the heights: 'none', 'mean', 'plane', or 'curvature' (second degree)"
    )
    resample_um: PositiveFinite | None = Field(
        None, description="pixel size to resample the map to, in micrometres; as measured if left out"
    )
    youngs_modulus_1_gpa: YoungsModulus | None = Field(
        None, description="Young's modulus of the first body, in GPa; 'inf' if rigid"
    )
    poissons_ratio_1: PoissonsRatio | None = Field(None, description="Poisson's ratio of the first body")
    youngs_modulus_2_gpa: YoungsModulus | None = Field(
        None, description="Young's modulus of the second body, in GPa; 'inf' if rigid"
    )
    poissons_ratio_2: PoissonsRatio | None = Field(None, description="Poisson's ratio of the second body")
    effective_modulus_gpa: PositiveFinite | None = Field(
        None,
        description="effective modulus E* of the two bodies together, in GPa",
        validate_default=True,
    )
    hardness_gpa: PositiveFinite | None = Field(
        None, description="highest pressure that the softer body bears, in GPa; elastic if left out"
    )
    resistivity_ohm_m: PositiveFinite | None = Field(
        None, description="mean resistivity of the two bodies, in ohm m; without it no resistance is calculated"
    )
    boundary: Boundary = Field(
        "free", description="boundary: 'free' (an isolated patch on a half-space) or 'periodic' (the map repeats)"
    )

    @field_validator("pixel_size_um")
    @classmethod
    def _one_pixel_size(cls, value: float | None, info: ValidationInfo) -> float | None:
        choose_one("pixel_size_um", value, ("pixel_size_x_um", "pixel_size_y_um"), info.data)
        return value

    @field_validator("effective_modulus_gpa")
    @classmethod
    def _one_material(cls, value: float | None, info: ValidationInfo) -> float | None:
        if not choose_one("effective_modulus_gpa", value, BODIES, info.data):
            every = ", ".join(BODIES)
            raise PydanticCustomError(
                "missing", f"effective_modulus_gpa is missing: give the {meaning('effective_modulus_gpa')}, or {every}."
            )
        return value

    @classmethod
    def parse(cls, values: Mapping[str, Any]) -> Self:
        """Build from loose values, such as those of a command line.

        Raises:
            InvalidFormError: fields are missing or not valid.
        """
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            raise InvalidFormError(field_errors(error.errors())) from error


class ProblemForm(BodiesForm):
    """Two bodies and the load that presses them together."""

    load_n: PositiveFinite = Field(description="total normal force on the whole map, in N")


def meaning(name: str) -> str:
    """What a field of the form is, to complete the sentence "give the ..."."""
    return str(ProblemForm.model_fields[name].description)


def parse_accuracy(value: object) -> Accuracy:
    """An accuracy from text.

    Raises:
        AccuracyError: neither a word of ``model.methods.TARGETS`` nor a number from 0 to 1.
    """
    try:
        accuracy: Accuracy = float(str(value))
    except ValueError:
        accuracy = cast(Accuracy, value)
    target_of(accuracy)
    return accuracy


def choose_one(name: str, value: object, others: tuple[str, ...], given: Mapping[str, Any]) -> bool:
    """Refuse anything but either the one field, all of the others, or nothing; whether there is something."""
    if any(other not in given for other in others):
        return True  # one of them has its own error already
    present = [other for other in others if given[other] is not None]
    every = ", ".join(others)
    if value is not None and present:
        raise PydanticCustomError("ambiguous", f"{name} and {', '.join(present)} are given; give one or the other.")
    if value is None and 0 < len(present) < len(others):
        absent = ", ".join(other for other in others if given[other] is None)
        raise PydanticCustomError("missing", f"{absent} missing: {every} go together, or give {name} alone.")
    return value is not None or bool(present)


def field_errors(errors: Iterable[Mapping[str, Any]], forms: Sequence[type[BaseModel]] = (ProblemForm,)) -> list[FieldError]:
    """Pydantic's error list as messages for people, in the order of the fields.

    Args:
        errors: of pydantic.
        forms: that say what each field is; the first is the one that was filled in.
    """
    return [_field_error(error, forms) for error in errors]


def _field_error(error: Mapping[str, Any], forms: Sequence[type[BaseModel]]) -> FieldError:
    field = str(error["loc"][-1])
    descriptions = (form.model_fields[field].description for form in forms if field in form.model_fields)
    wanted = next(descriptions, "value that the documentation at /docs asks for")
    value = error.get("input")
    match error["type"]:
        case "missing" if error["msg"] == "Field required":
            return FieldError(field, "missing", f"{field} is missing: give the {wanted}.")
        case "missing" | "ambiguous":
            return FieldError(field, error["type"], error["msg"])
        case "finite_number":
            return FieldError(field, "not-finite", f"{field} is {value}; it must be a finite number: the {wanted}.")
        case "greater_than" if error["ctx"]["gt"] == 0:
            return FieldError(field, "not-positive", f"{field} is {value}; it must be positive: the {wanted}.")
        case "greater_than" | "less_than_equal" if field.startswith("poisson"):
            return FieldError(field, "out-of-range", f"{field} is {value}; it must lie in (-1, 0.5]: the {wanted}.")
        case "float_parsing" | "float_type":
            return FieldError(field, "not-a-number", f"{field} is {value!r}; it must be a number: the {wanted}.")
        case "extra_forbidden":
            known = sorted(forms[0].model_fields)
            similar = get_close_matches(field, known, 1)
            advice = f"did you mean {similar[0]}?" if similar else f"it takes {', '.join(known)}."
            return FieldError(field, "unknown", f"{field} is no field of this form; {advice}")
        case "literal_error":
            return FieldError(field, "invalid", f"{field} is {value!r}; it must be {error['ctx']['expected']}.")
        case "greater_than_equal" | "less_than_equal" | "int_parsing":
            return FieldError(field, "invalid", f"{field} is {value!r}; {error['msg'].lower()}: the {wanted}.")
        case _:
            return FieldError(field, "invalid", f"{field} is {value!r}; give the {wanted}.")
