"""Contact masks as 1-bit PNG files, white in contact."""

from io import BytesIO

import numpy as np
from PIL import Image

from solver.problem import BoolArray


def mask_png(mask: BoolArray) -> bytes:
    """Encode a mask of shape (rows, columns); the first row is the top of the image."""
    file = BytesIO()
    Image.fromarray(mask).save(file, format="PNG", bits=1)
    return file.getvalue()


def mask_from_png(data: bytes) -> BoolArray:
    """Decode a mask that :func:`mask_png` encoded."""
    mask: BoolArray = np.asarray(Image.open(BytesIO(data), formats=["PNG"]), dtype=np.bool_)
    return mask
