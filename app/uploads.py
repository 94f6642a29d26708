"""Decode an uploaded PNG to a height map: checked before it is decoded, decoded once, every bit kept."""

import io
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from app.errors import (
    ColourPngError,
    ConstantHeightsError,
    DamagedPngError,
    ImageTooLargeError,
    LowBitDepthError,
    NotPngError,
    PalettePngError,
    TransparentPngError,
    TruncatedPngError,
)
from solver.problem import FloatArray

SIGNATURE = b"\x89PNG\r\n\x1a\n"
HEADER = struct.Struct(">8sI4sIIBB")
"""Signature, then the IHDR chunk: its length, name, columns, rows, bit depth, colour type (PNG, section 11.2.2)."""

GREY, COLOUR, PALETTE, GREY_ALPHA, COLOUR_ALPHA = 0, 2, 3, 4, 6

LARGEST_SIDE = 4096
"""Pixels a side; the solver takes more, but a service has several at a time in memory."""

EXPORT = "Export the heights as an 8- or, better, 16-bit grey PNG"


@dataclass(frozen=True, eq=False)
class HeightMap:
    """A decoded height map, still without units.

    Attributes:
        codes: grey levels as in the file, shape (rows, columns); 0 is the lowest height.
        bit_depth: 8 or 16.
    """

    codes: NDArray[np.uint16]
    bit_depth: int

    @property
    def highest_code(self) -> int:
        """Grey level of the highest height, 255 or 65535."""
        return int(2**self.bit_depth - 1)

    def heights(self, height_range: float) -> FloatArray:
        """Heights in m, shape (rows, columns).

        Args:
            height_range: height from code 0 to the highest code, in m.
        """
        scaled: FloatArray = self.codes / self.highest_code * height_range
        return scaled


def decode_png(data: bytes) -> HeightMap:
    """Read a grey PNG of 8 or 16 bits; gamma and colour profiles are ignored.

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
    if codes.min() == codes.max():
        raise ConstantHeightsError(
            f"All pixels have the same grey level, {codes[0, 0]}, so there is no roughness to press on. "
            "Check the export: the lowest height should be black and the highest white."
        )
    return HeightMap(codes, bit_depth)


def _check_header(data: bytes) -> int:
    """The bit depth of a PNG that may be decoded."""
    if not data:
        raise NotPngError(f"The file is empty. {EXPORT}.")
    if not data.startswith(SIGNATURE[: len(data)]):
        raise NotPngError(f"The file is not a PNG: it begins with {data[:8]!r}. {EXPORT}.")
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
    if max(rows, columns) > LARGEST_SIDE:
        raise ImageTooLargeError(
            f"The PNG announces {rows} x {columns} pixels; each side may have up to {LARGEST_SIDE}. "
            "Crop the map or bin its pixels."
        )
    return int(bit_depth)


def _ends_well(data: bytes) -> bool:
    """Whether the file runs on to its closing IEND chunk."""
    return b"IEND" in data[-64:]
