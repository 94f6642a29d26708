"""Files of measuring instruments, with their own units, read by the SurfaceTopography package.

Its arrays have x first; ours have rows, that is y, first.
"""

import io
import warnings
from typing import Any

import numpy as np
from SurfaceTopography.Exceptions import CannotDetectFileFormat
from SurfaceTopography.IO import detect_format, open_topography
from SurfaceTopography.Support.UnitConversion import get_unit_conversion_factor

from app.errors import DamagedFileError, NotAHeightMapError, UnknownFormatError, UploadError
from app.height_map import HeightMap, check_size

READ = "PNG, TIFF, NPY, tables of numbers (CSV), and the files of most instruments (X3P, SUR, SDF, OPD, PLU, AL3D, DI, ...)"


UNSIGNED = ("hgt",)
"""Formats without a signature, which any file of the right size would be."""


def read_instrument(data: bytes) -> HeightMap:
    """Read the default channel of an instrument's file.

    Raises:
        UploadError: one of its subclasses; the message says what to change.
    """
    try:
        with warnings.catch_warnings(action="ignore"):
            return _read(data)
    except (UploadError, MemoryError):
        raise
    except CannotDetectFileFormat as error:
        raise UnknownFormatError(
            f"The file begins with {data[:8]!r}, which no format that is read does. Send {READ}."
        ) from error
    except Exception as error:
        raise DamagedFileError(f"The file is damaged or of an unusual kind ({error}). Export it again.") from error


def _read(data: bytes) -> HeightMap:
    name = detect_format(io.BytesIO(data))
    if name in UNSIGNED:
        raise CannotDetectFileFormat(name)
    reader: Any = open_topography(io.BytesIO(data), format=name)
    channel = reader.default_channel
    check_size(tuple(channel.nb_grid_pts))
    sizes = channel.physical_sizes
    needed = {} if sizes else {"physical_sizes": tuple(channel.nb_grid_pts)}
    topography: Any = reader.topography(channel_index=channel.index, **needed)
    if not topography.is_uniform:
        raise NotAHeightMapError("The file holds points that lie on no grid. Export a map with rows and columns.")
    heights = np.ma.filled(topography.heights().astype(np.float64), np.nan).T
    unit = None if topography.unit is None else get_unit_conversion_factor(topography.unit, "m")
    pixel_size = None
    if unit is not None and sizes:
        width, height = sizes
        pixel_size = (unit * height / heights.shape[0], unit * width / heights.shape[1])
    finite = np.where(np.isfinite(heights), heights, np.nan)
    return HeightMap(np.ascontiguousarray(finite), name.upper(), height_unit=unit, pixel_size=pixel_size)
