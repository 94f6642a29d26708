"""PNG files: every bit kept, every refusal its own."""

import struct
import zlib

import numpy as np
import pytest

from app.errors import (
    ColourPngError,
    ConstantHeightsError,
    DamagedPngError,
    ImageTooLargeError,
    LowBitDepthError,
    PalettePngError,
    TransparentPngError,
    TruncatedPngError,
)
from app.formats.png import read_png
from app.uploads import decode
from tests.app.files import IEND, chunk, header, png, surface_codes, surface_png, with_chunk

GREY = (np.arange(64 * 64, dtype=np.uint32) % 251).astype(np.uint8).reshape(64, 64)


def test_sixteen_bits_survive() -> None:
    codes = np.random.default_rng(0).permutation(65536).astype(np.uint16).reshape(128, 512)
    height_map = read_png(png(codes))
    assert height_map.bit_depth == 16
    np.testing.assert_array_equal(height_map.values, codes / 65535)


def test_values_run_from_zero_to_one_in_rows_and_columns() -> None:
    codes = np.array([[0, 32768, 65535], [7, 8, 9]], dtype=np.uint16)
    values = read_png(png(codes)).values
    assert values.shape == (2, 3)
    assert values[0, 0] == 0
    assert values[0, 2] == 1
    assert values[1, 0] == pytest.approx(7 / 65535)


def test_eight_bits_span_the_same_range() -> None:
    height_map = read_png(png(np.array([[0, 51, 255]], dtype=np.uint8)))
    assert height_map.bit_depth == 8
    np.testing.assert_allclose(height_map.values, [[0, 0.2, 1]])


def test_gamma_is_ignored() -> None:
    data = surface_png()
    with_gamma = with_chunk(data, b"gAMA", struct.pack(">I", 45455))
    np.testing.assert_array_equal(read_png(with_gamma).values, surface_codes() / 65535)


def flipped(data: bytes, at: int) -> bytes:
    return data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]


PLAIN = surface_png()
BOMB = header(60000, 60000) + chunk(b"IDAT", zlib.compress(bytes(10**6), 9)) + IEND
TEXT_BOMB = with_chunk(PLAIN, b"zTXt", b"comment\x00\x00" + zlib.compress(bytes(10**8), 9))


@pytest.mark.parametrize(
    ("data", "error", "words"),
    [
        pytest.param(PLAIN[:20], TruncatedPngError, "within its header", id="cut-in-header"),
        pytest.param(PLAIN[: len(PLAIN) // 2], TruncatedPngError, "ends before", id="cut-in-half"),
        pytest.param(PLAIN[:-12], TruncatedPngError, "ends before", id="without-end"),
        pytest.param(flipped(PLAIN, len(PLAIN) // 2), DamagedPngError, "damaged", id="bit-flipped"),
        pytest.param(TEXT_BOMB, DamagedPngError, "damaged", id="text-bomb"),
        pytest.param(header(8, 8) + chunk(b"IDAT", zlib.compress(bytes(20))) + IEND, DamagedPngError, "damaged", id="short"),
        pytest.param(png(GREY, "RGB"), ColourPngError, "colour", id="colour"),
        pytest.param(png(GREY, "RGBA"), TransparentPngError, "alpha", id="colour-alpha"),
        pytest.param(png(GREY, "LA"), TransparentPngError, "alpha", id="grey-alpha"),
        pytest.param(with_chunk(PLAIN, b"tRNS", b"\x00\x00"), TransparentPngError, "transparent", id="transparent-level"),
        pytest.param(png(GREY, "P"), PalettePngError, "palette", id="palette"),
        pytest.param(png(GREY, "1"), LowBitDepthError, "1 bits", id="one-bit"),
        pytest.param(header(64, 64, bit_depth=2), LowBitDepthError, "2 bits", id="two-bit"),
        pytest.param(header(64, 64, bit_depth=4), LowBitDepthError, "4 bits", id="four-bit"),
        pytest.param(BOMB, ImageTooLargeError, "60000 x 60000", id="bomb"),
        pytest.param(png(np.full((64, 64), 9, np.uint16)), ConstantHeightsError, "same height", id="constant"),
    ],
)
def test_refusals(data: bytes, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words) as caught:
        decode(data)
    assert type(caught.value) is error
