"""Files for tests, written by hand where no package would."""

import io
import struct
import zlib

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from solver import random_midpoint_displacement

IEND = b"\x00\x00\x00\x00IEND\xaeB`\x82"


def png(codes: NDArray[np.generic], mode: str | None = None) -> bytes:
    """A PNG of an array, or of what Pillow converts it to."""
    image = Image.fromarray(codes)
    buffer = io.BytesIO()
    (image.convert(mode) if mode else image).save(buffer, format="PNG")
    return buffer.getvalue()


def surface_codes(size: int = 64, seed: int = 1) -> NDArray[np.uint16]:
    """A random midpoint surface in 16 bits."""
    return np.rint(random_midpoint_displacement(size, hurst=0.7, seed=seed) * 65535).astype(np.uint16)


def surface_png(size: int = 64, seed: int = 1) -> bytes:
    """A 16-bit PNG of a random midpoint surface."""
    return png(surface_codes(size, seed))


def ascii_grid(heights: NDArray[np.float64]) -> bytes:
    """A map of 96 x 64 um with heights in m, as the AFM program Gwyddion exports it."""
    lines = ["# Channel: Height", "# Width: 96.0 µm", "# Height: 64.0 µm", "# Value units: m"]
    return "\n".join(lines + ["\t".join(f"{value:.9e}" for value in row) for row in heights]).encode()


def chunk(name: bytes, data: bytes) -> bytes:
    """A PNG chunk with its checksum."""
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def header(rows: int, columns: int, bit_depth: int = 16, colour_type: int = 0) -> bytes:
    """Signature and IHDR."""
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", columns, rows, bit_depth, colour_type, 0, 0, 0))


def with_chunk(data: bytes, name: bytes, contents: bytes) -> bytes:
    """The same PNG with a chunk more, right after its header."""
    return data[:33] + chunk(name, contents) + data[33:]
