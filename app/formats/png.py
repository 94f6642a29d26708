"""Grey PNG files, checked before they are decoded."""

import io
import struct

import numpy as np
from PIL import Image

from app.errors import (
    ColourPngError,
    DamagedPngError,
    LowBitDepthError,
    PalettePngError,
    TransparentPngError,
    TruncatedPngError,
)
from app.height_map import HeightMap, check_size

SIGNATURE = b"\x89PNG\r\n\x1a\n"
HEADER = struct.Struct(">8sI4sIIBB")
"""Signature, then the IHDR chunk: its length, name, columns, rows, bit depth, colour type (PNG, section 11.2.2)."""

GREY, COLOUR, PALETTE, GREY_ALPHA, COLOUR_ALPHA = 0, 2, 3, 4, 6

EXPORT = "Export the heights as an 8- or, better, 16-bit grey PNG"


def read_png(data: bytes) -> HeightMap:
    """Read a grey PNG of 8 or 16 bits, every bit kept; gamma and colour profiles are ignored.

    Raises:
        UploadError: one of its subclasses; the message says what to change.
    """
    bit_depth = _check_header(data)
    try:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as image:
            image.verify()
        with Image.open(io.BytesIO(data), formats=["PNG"]) as image:
            if "transparency" in image.info:
                raise TransparentPngError(f"The PNG marks a grey level as transparent. {EXPORT} without transparency.")
            codes = np.asarray(image).astype(np.uint16)
    except (OSError, SyntaxError, ValueError, EOFError, struct.error) as error:
        if not _ends_well(data):
            raise TruncatedPngError(
                f"The PNG file ends before its picture does ({len(data)} bytes arrived). Export or upload it again."
            ) from error
        raise DamagedPngError(f"The PNG file is damaged ({error}). Export or upload it again.") from error
    return HeightMap(codes / (2**bit_depth - 1), "PNG", bit_depth=bit_depth)


def png_shape(data: bytes) -> tuple[int, int] | None:
    """(rows, columns) as the header of a PNG says; None if it ends before."""
    if len(data) < HEADER.size:
        return None
    _, _, _, columns, rows, _, _ = HEADER.unpack_from(data)
    return rows, columns


def _check_header(data: bytes) -> int:
    """The bit depth of a PNG that may be decoded."""
    if len(data) < HEADER.size:
        raise TruncatedPngError(f"The PNG file ends after {len(data)} bytes, within its header. Upload it again.")
    _, _, name, columns, rows, bit_depth, colour_type = HEADER.unpack_from(data)
    if name != b"IHDR":
        raise DamagedPngError(f"The PNG file begins with the chunk {name!r} in place of IHDR. Export it again.")
    if colour_type == PALETTE:
        raise PalettePngError(f"The PNG has a palette, whose colours are no heights. {EXPORT} without a palette.")
    if colour_type in (GREY_ALPHA, COLOUR_ALPHA):
        raise TransparentPngError(f"The PNG has an alpha channel. {EXPORT} without transparency.")
    if colour_type == COLOUR:
        raise ColourPngError(f"The PNG is in colour, and a colour map cannot be turned back into heights. {EXPORT}.")
    if bit_depth not in (8, 16):
        raise LowBitDepthError(f"The PNG has {bit_depth} bits per pixel, {2**bit_depth} heights in all. {EXPORT}.")
    check_size((rows, columns))
    return int(bit_depth)


def _ends_well(data: bytes) -> bool:
    """Whether the file runs on to its closing IEND chunk."""
    return b"IEND" in data[-64:]
