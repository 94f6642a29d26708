"""What was read from an upload, so that people see it before the answer, and what looks wrong with it."""

import numpy as np
from pydantic import BaseModel, Field

from app.contact_problem import SAME, differ, given_pixel_size
from app.forms import BodiesForm
from app.height_map import HeightMap
from solver.problem import ContactProblem

FEW_LEVELS = 256
CLIPPED_SHARE = 0.01
TILTED_SHARE = 0.8
USUAL_RMS_SLOPES = (1e-4, 3.0)
SEAM_RATIO = 3.0


class Surface(BaseModel):
    """The height map as it was read."""

    rows: int
    columns: int
    pixel_size_x_um: float = Field(description="distance between neighbouring columns")
    pixel_size_y_um: float = Field(description="distance between neighbouring rows")
    file_format: str
    bit_depth: int | None = Field(description="of a grey image; null for a file of numbers")
    missing_pixels: int = Field(description="pixels without a height, which were given that of the nearest one with")
    height_range_um: float = Field(description="from the lowest to the highest pixel of this map")
    rms_height_um: float = Field(description="about the mean height")
    rms_slope: float = Field(description="root mean square gradient, dimensionless")


def read_surface(height_map: HeightMap, problem: ContactProblem) -> Surface:
    """Describe what was read."""
    dy, dx = problem.pixel_size
    rows, columns = problem.shape
    return Surface(
        rows=rows,
        columns=columns,
        pixel_size_x_um=dx * 1e6,
        pixel_size_y_um=dy * 1e6,
        file_format=height_map.file_format,
        bit_depth=height_map.bit_depth,
        missing_pixels=height_map.missing,
        height_range_um=float(np.ptp(problem.heights)) * 1e6,
        rms_height_um=problem.rms_height * 1e6,
        rms_slope=problem.rms_slope,
    )


def surface_warnings(height_map: HeightMap, form: BodiesForm, problem: ContactProblem) -> list[str]:
    """What looks wrong with a height map, each as one sentence with the cure."""
    found = _grey_levels(height_map) + _other_units(height_map, form)
    if missing := height_map.missing:
        found.append(
            f"{missing} pixels ({100 * missing / height_map.values.size:.2g} %) have no height; each was given that of the "
            "nearest pixel with one."
        )
    tilt = _tilted_share(problem)
    if tilt > TILTED_SHARE:
        found.append(
            f"A tilt makes up {tilt:.0%} of the height variance, so contact gathers at one side; "
            "level the map with detrend=plane if the tilt is not real."
        )
    lowest_slope, highest_slope = USUAL_RMS_SLOPES
    if not lowest_slope <= problem.rms_slope <= highest_slope:
        found.append(
            f"The rms slope is {problem.rms_slope:.2g}, which engineering surfaces do not have; "
            "check the units of pixel size and heights."
        )
    if problem.boundary == "periodic" and _cliff_at_seam(problem):
        found.append(
            "Opposite edges of the map do not match, so that repeating it makes cliffs; "
            "use the free boundary unless the map really repeats."
        )
    return found


def _grey_levels(height_map: HeightMap) -> list[str]:
    """What is wrong with the grey levels of an image."""
    if height_map.bit_depth is None:
        return []
    highest = 2**height_map.bit_depth - 1
    counts = np.bincount(np.rint(height_map.values * highest).astype(np.intp).ravel(), minlength=highest + 1)
    shares = counts / height_map.values.size
    levels = int(np.count_nonzero(counts))
    found = []
    if height_map.bit_depth == 8:
        found.append(
            "The image has 8 bits: heights are quantised to 1/255 of the height range; a 16-bit image keeps fine roughness."
        )
    elif levels <= FEW_LEVELS:
        found.append(f"The 16-bit image has only {levels} distinct heights; it may have been made from 8 bits.")
    for share, name in ((shares[0], "lowest"), (shares[-1], "highest")):
        if share > CLIPPED_SHARE:
            found.append(f"{share:.1%} of the pixels are at the {name} level: heights beyond it may be clipped.")
    return found


def _other_units(height_map: HeightMap, form: BodiesForm) -> list[str]:
    """Where the request contradicts the file; the request counts."""
    found = []
    given, held = given_pixel_size(form), height_map.pixel_size
    if given and held and differ(given, held):
        dy, dx = (size * 1e6 for size in held)
        found.append(f"The file says that its pixels are {dx:.6g} x {dy:.6g} um; those of the request are used.")
    if (
        form.height_unit_um
        and height_map.height_unit
        and abs(form.height_unit_um * 1e-6 / height_map.height_unit - 1) > SAME
    ):
        found.append(f"The file says that its unit of height is {height_map.height_unit:g} m; that of the request is used.")
    return found


def _tilted_share(problem: ContactProblem) -> float:
    """Share of the height variance that the best-fitting plane explains."""
    rows, columns = problem.shape
    y = np.linspace(-1, 1, rows)[:, np.newaxis]
    x = np.linspace(-1, 1, columns)[np.newaxis, :]
    deviation = problem.heights - problem.heights.mean()
    explained = sum((deviation * axis).mean() ** 2 / (axis**2).mean() for axis in (y, x))
    return float(explained / problem.rms_height**2)


def _cliff_at_seam(problem: ContactProblem) -> bool:
    """Whether the rms height step across the seam of a periodic map is out of proportion with the steps inside."""
    for heights in (problem.heights, problem.heights.T):
        across = np.mean((heights[0] - heights[-1]) ** 2)
        inside = np.mean(np.diff(heights, axis=0) ** 2)
        if across > SEAM_RATIO**2 * inside:
            return True
    return False
