"""A height map as a file holds it."""

from dataclasses import dataclass

import numpy as np

from app.errors import ConstantHeightsError, ImageTooLargeError, MissingHeightsError, NotAHeightMapError
from solver.problem import FloatArray

LARGEST_SIDE = 4096
"""Pixels a side; the solver takes more, but a service has several at a time in memory."""

MOST_MISSING = 0.5
"""Share of the pixels that may be missing."""


@dataclass(frozen=True, eq=False)
class HeightMap:
    """A decoded height map, perhaps still without units.

    Attributes:
        values: heights in the unit of the file, high touches first, shape (rows, columns); NaN where nothing was measured.
        file_format: its usual name.
        bit_depth: of a grey image, 8 or 16, whose values run from 0, black, to 1, white; None for files of numbers.
        height_unit: what a value of 1 means, in m; None where the file does not say.
        pixel_size: dy, dx, in m; None where the file does not say.
    """

    values: FloatArray
    file_format: str
    bit_depth: int | None = None
    height_unit: float | None = None
    pixel_size: tuple[float, float] | None = None

    @property
    def missing(self) -> int:
        """Pixels without a height."""
        return int(np.count_nonzero(np.isnan(self.values)))


def check_size(shape: tuple[int, ...]) -> None:
    """Refuse what cannot be decoded, before it is.

    Raises:
        NotAHeightMapError: not two dimensions.
        ImageTooLargeError: more than ``LARGEST_SIDE`` pixels a side.
    """
    if len(shape) != 2:
        raise NotAHeightMapError(f"The file holds an array of {len(shape)} dimensions; a height map has rows and columns.")
    rows, columns = shape
    if max(rows, columns) > LARGEST_SIDE:
        raise ImageTooLargeError(
            f"The file announces {rows} x {columns} pixels; each side may have up to {LARGEST_SIDE}. "
            "Crop the map or bin its pixels."
        )


def checked(height_map: HeightMap) -> HeightMap:
    """The same map, if there is something to press on.

    Raises:
        MissingHeightsError: most pixels are missing.
        ConstantHeightsError: all heights are the same.
    """
    values, missing = height_map.values, height_map.missing
    if missing > MOST_MISSING * values.size:
        raise MissingHeightsError(
            f"{missing} of {values.size} pixels have no height; at most {MOST_MISSING:.0%} are filled in. "
            "Measure again, or crop the map to its good part before the upload."
        )
    if np.nanmin(values) == np.nanmax(values):
        raise ConstantHeightsError(
            f"All pixels have the same height, {np.nanmin(values):g}, so there is no roughness to press on. "
            "Check the export: in an image the lowest height should be black and the highest white."
        )
    return height_map
