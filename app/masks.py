"""Contact masks as 1-bit PNG files."""

import io

from PIL import Image

from solver.problem import BoolArray


def encode_mask(mask: BoolArray) -> bytes:
    """A 1-bit grey PNG, white where the bodies touch, rows and columns as in the mask."""
    buffer = io.BytesIO()
    Image.fromarray(mask).save(buffer, format="PNG")
    return buffer.getvalue()
