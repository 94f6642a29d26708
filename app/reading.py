"""From uploaded files to a contact problem, with what was read on the way: decoded once, validated once."""

from collections.abc import Callable
from dataclasses import dataclass

from app.contact_problem import contact_problem
from app.forms import BodiesForm
from app.height_map import HeightMap
from app.surface import Surface, read_surface, surface_warnings
from solver import ContactProblem

Decoder = Callable[[bytes], HeightMap]


@dataclass(frozen=True)
class Files:
    """Uploaded height maps.

    Attributes:
        surface: of the rough surface.
        surface_2: of the surface that it touches; None for a flat.
    """

    surface: bytes
    surface_2: bytes | None = None


@dataclass(frozen=True, eq=False)
class Reading:
    """A contact problem, what the first file holds, and what looks wrong with it."""

    problem: ContactProblem
    surface: Surface
    warnings: list[str]


def read_problem(files: Files, form: BodiesForm, load: float, decode: Decoder) -> Reading:
    """Decode and validate.

    Args:
        files: as they came.
        form: units and material.
        load: in N.
        decode: from bytes to a height map.

    Raises:
        UploadError, InvalidFormError, InvalidProblemError: the message says what to change.
    """
    height_map = decode(files.surface)
    second = decode(files.surface_2) if files.surface_2 else None
    problem = contact_problem(form, load, height_map, second)
    return Reading(problem, read_surface(height_map, problem), surface_warnings(height_map, form, problem))
