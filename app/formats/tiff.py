"""TIFF files: grey images of 8 or 16 bits, or floating-point numbers."""

import io
import warnings

import numpy as np
from PIL import Image, UnidentifiedImageError

from app.errors import DamagedFileError, NotAHeightMapError
from app.height_map import HeightMap, check_size

BIT_DEPTHS = {"L": 8, "I;16": 16, "I;16B": 16}
NUMBERS = ("F", "I")


def read_tiff(data: bytes) -> HeightMap:
    """Read the first page of a TIFF file; colour, palettes and transparency are no heights.

    Raises:
        UploadError: one of its subclasses; the message says what to change.
    """
    try:
        with warnings.catch_warnings(action="ignore"), Image.open(io.BytesIO(data), formats=["TIFF"]) as image:
            check_size((image.height, image.width))
            if image.mode not in (*BIT_DEPTHS, *NUMBERS):
                raise NotAHeightMapError(
                    f"The TIFF has pixels of the kind {image.mode}. Export the heights as one grey channel of 8 or 16 bits, "
                    "or as 32-bit floating-point numbers."
                )
            bit_depth = BIT_DEPTHS.get(image.mode)
            values = np.asarray(image).astype(np.float64)
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError, TypeError, KeyError, EOFError) as error:
        raise DamagedFileError(f"The TIFF file is damaged or of an unusual kind ({error}). Export it again.") from error
    if bit_depth is None:
        return HeightMap(np.where(np.isfinite(values), values, np.nan), "TIFF")
    return HeightMap(values / (2**bit_depth - 1), "TIFF", bit_depth=bit_depth)
