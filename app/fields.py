"""Fields of an answer as files: PNG to look at, netCDF with a unit on everything."""

import io
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from PIL import Image
from scipy.io import netcdf_file

from worker.arrays import Field

FieldName = Literal["heights", "pressure", "probability"]

UNITS: dict[str, str] = {"heights": "m", "pressure": "Pa", "probability": "1", "contact_mask": "1"}

MEANINGS: dict[str, str] = {
    "heights": "heights as they were pressed, high touches first",
    "pressure": "contact pressure",
    "probability": "probability of contact",
    "contact_mask": "1 where the bodies touch",
}

HIGHEST_CODE = 65535


def picture(values: Field) -> bytes:
    """As a 16-bit grey PNG file, black the lowest value and white the highest."""
    shades = values.astype(np.float64)
    lowest, highest = shades.min(), shades.max()
    codes = np.rint((shades - lowest) / ((highest - lowest) or 1.0) * HIGHEST_CODE).astype(np.uint16)
    file = io.BytesIO()
    Image.fromarray(codes).save(file, format="PNG", compress_level=1)
    return file.getvalue()


def bundle(fields: Mapping[str, Field], pixel_size: tuple[float, float], about: dict[str, str]) -> bytes:
    """As a netCDF 3 file with coordinates y and x.

    Args:
        fields: of shape (rows, columns), by names of ``UNITS``.
        pixel_size: dy, dx in m.
        about: global attributes.
    """
    file = io.BytesIO()
    rows, columns = next(iter(fields.values())).shape
    with netcdf_file(file, "w", version=2) as root:
        for name, text in about.items():
            setattr(root, name, text)
        for axis, count, step in (("y", rows, pixel_size[0]), ("x", columns, pixel_size[1])):
            root.createDimension(axis, count)
            coordinate: Any = root.createVariable(axis, "d", (axis,))
            coordinate[:] = np.arange(count) * step
            coordinate.units = "m"
        for name, values in fields.items():
            kind = "b" if values.dtype == np.bool_ else values.dtype.char
            variable: Any = root.createVariable(name, kind, ("y", "x"))
            variable[:] = values
            variable.units = UNITS[name]
            variable.long_name = MEANINGS[name]
        root.flush()
        return file.getvalue()
