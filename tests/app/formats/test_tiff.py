"""TIFF files: grey images as images, numbers as numbers."""

import io

import numpy as np
import pytest
from PIL import Image

from app.errors import DamagedFileError, NotAHeightMapError
from app.formats.tiff import read_tiff
from tests.app.files import surface_codes

CODES = surface_codes()


def tiff(values: np.ndarray, mode: str | None = None, **options: str) -> bytes:
    file = io.BytesIO()
    image = Image.fromarray(values)
    (image.convert(mode) if mode else image).save(file, format="TIFF", **options)
    return file.getvalue()


@pytest.mark.parametrize("compression", ["raw", "tiff_lzw", "tiff_adobe_deflate"])
def test_sixteen_bits_survive(compression: str) -> None:
    height_map = read_tiff(tiff(CODES, compression=compression))
    assert height_map.bit_depth == 16
    np.testing.assert_array_equal(height_map.values, CODES / 65535)


def test_eight_bits_span_the_same_range() -> None:
    height_map = read_tiff(tiff(np.array([[0, 51, 255]], dtype=np.uint8)))
    assert height_map.bit_depth == 8
    np.testing.assert_allclose(height_map.values, [[0, 0.2, 1]])


def test_floating_point_numbers_stay_what_they_are() -> None:
    values = (CODES * 1e-9).astype(np.float32)
    values[2, 3] = np.nan
    height_map = read_tiff(tiff(values))
    assert height_map.bit_depth is None
    assert height_map.missing == 1
    np.testing.assert_array_equal(height_map.values, values.astype(np.float64))


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "P", "1", "LA"])
def test_colour_and_the_like_are_no_heights(mode: str) -> None:
    with pytest.raises(NotAHeightMapError, match=mode):
        read_tiff(tiff((CODES // 256).astype(np.uint8), mode))


def test_damage() -> None:
    whole = tiff(CODES)
    for data in (whole[:100], whole[: len(whole) // 2], b"II*\x00 and nothing"):
        with pytest.raises(DamagedFileError):
            read_tiff(data)
