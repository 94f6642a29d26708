"""From uploaded files to a contact problem, with what was read on the way: decoded once, validated once."""

from collections.abc import Callable
from dataclasses import dataclass

from app.contact_problem import contact_problem
from app.formats.png import png_shape
from app.forms import BodiesForm
from app.height_map import HeightMap
from app.surface import Surface, read_surface, surface_warnings
from app.uploads import decode as decode_here
from app.uploads import is_png
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
class Maps:
    """The same, decoded but for PNG files."""

    surface: bytes | HeightMap
    surface_2: bytes | HeightMap | None = None

    @classmethod
    def of(cls, files: Files, decode: Decoder) -> "Maps":
        """Decode what more than a check must come before.

        Raises:
            UploadError: the message says what to change.
        """
        first, second = files.surface, files.surface_2
        return cls(first if is_png(first) else decode(first), second if second is None or is_png(second) else decode(second))

    @property
    def shape(self) -> tuple[int, int] | None:
        """(rows, columns) of the first file; None if it does not say."""
        return png_shape(self.surface) if isinstance(self.surface, bytes) else self.surface.values.shape


@dataclass(frozen=True, eq=False)
class Reading:
    """A contact problem, what the first file holds, and what looks wrong with it."""

    problem: ContactProblem
    surface: Surface
    warnings: list[str]


def read_problem(maps: Files | Maps, form: BodiesForm, load: float, decode: Decoder = decode_here) -> Reading:
    """Decode what is not decoded yet, and validate.

    Args:
        maps: as they came, or decoded.
        form: units and material.
        load: in N.
        decode: from bytes to a height map.

    Raises:
        UploadError, InvalidFormError, InvalidProblemError: the message says what to change.
    """
    height_map = maps.surface if isinstance(maps.surface, HeightMap) else decode(maps.surface)
    second = decode(maps.surface_2) if isinstance(maps.surface_2, bytes) else maps.surface_2
    problem = contact_problem(form, load, height_map, second)
    return Reading(problem, read_surface(height_map, problem), surface_warnings(height_map, form, problem))
