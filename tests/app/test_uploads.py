"""Which format a file has is said by its contents."""

import io

import numpy as np
import pytest

from app.errors import ConstantHeightsError, MissingHeightsError, UnknownFormatError
from app.uploads import decode
from tests.app.files import surface_codes, surface_png

HEIGHTS = surface_codes().astype(np.float64)


def npy(values: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


def csv(values: np.ndarray) -> bytes:
    file = io.StringIO()
    np.savetxt(file, values, delimiter=",")
    return file.getvalue().encode()


@pytest.mark.parametrize(
    ("data", "name"), [(surface_png(), "PNG"), (npy(HEIGHTS), "NPY"), (csv(HEIGHTS), "table")], ids=["png", "npy", "csv"]
)
def test_every_format_holds_the_same_heights(data: bytes, name: str) -> None:
    height_map = decode(data)
    assert height_map.file_format == name
    scale = 65535 if height_map.bit_depth else 1
    np.testing.assert_allclose(height_map.values * scale, HEIGHTS, rtol=1e-12)


@pytest.mark.parametrize("data", [b"", b"hello", b"\x00" * 4000, b"GIF89a", b"\xff\xd8\xff\xe0 a picture"])
def test_what_is_no_height_map(data: bytes) -> None:
    with pytest.raises(UnknownFormatError, match=r"Send PNG|empty"):
        decode(data)


def test_a_constant_map_is_refused() -> None:
    with pytest.raises(ConstantHeightsError, match="7"):
        decode(npy(np.full((40, 40), 7.0)))


def test_a_map_with_few_heights_is_refused() -> None:
    sparse = np.where(np.random.default_rng(0).random(HEIGHTS.shape) < 0.6, np.nan, HEIGHTS)
    with pytest.raises(MissingHeightsError, match="pixels have no height"):
        decode(npy(sparse))
    sparse[:, :40] = HEIGHTS[:, :40]
    assert 0 < decode(npy(sparse)).missing < sparse.size / 2
