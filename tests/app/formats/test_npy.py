"""NPY files: numbers, never objects."""

import io
import pickle

import numpy as np
import pytest

from app.errors import DamagedFileError, ImageTooLargeError, NotAHeightMapError
from app.formats.npy import read_npy


def npy(values: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


@pytest.mark.parametrize("kind", [np.int16, np.uint8, np.float32, np.float64, ">f8"])
def test_numbers_of_any_kind(kind: str) -> None:
    values = np.arange(20).reshape(4, 5).astype(kind)
    height_map = read_npy(npy(values))
    np.testing.assert_array_equal(height_map.values, values)
    assert height_map.values.dtype == np.float64
    assert height_map.height_unit is None
    assert height_map.pixel_size is None


def test_columns_first_in_the_file_are_columns_still() -> None:
    values = np.asfortranarray(np.arange(12.0).reshape(3, 4))
    np.testing.assert_array_equal(read_npy(npy(values)).values, values)


def test_what_is_not_finite_is_missing() -> None:
    assert read_npy(npy(np.array([[1.0, np.inf], [np.nan, 2.0]]))).missing == 2


class Bomb:
    def __reduce__(self) -> tuple[object, tuple[str]]:
        return pytest.fail, ("the pickle was loaded",)


def test_objects_are_never_unpickled() -> None:
    header = npy(np.empty((2, 2), object))[:128]
    with pytest.raises(NotAHeightMapError, match="object"):
        read_npy(header + pickle.dumps([Bomb()] * 4))


def announced(shape: str) -> bytes:
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


@pytest.mark.parametrize(
    ("data", "error"),
    [
        (npy(np.zeros((3, 3)))[:-8], DamagedFileError),
        (announced("(100, 100)"), DamagedFileError),
        (announced("(-1, 5)"), DamagedFileError),
        (announced("(3, 3"), DamagedFileError),
        (announced("(3, 3), 'more': open"), DamagedFileError),
        (announced("(50000, 50000)"), ImageTooLargeError),
        (npy(np.zeros(9)), NotAHeightMapError),
        (npy(np.zeros((3, 3, 3))), NotAHeightMapError),
        (npy(np.zeros((3, 3), complex)), NotAHeightMapError),
        (npy(np.zeros((3, 3), "U5")), NotAHeightMapError),
        (b"\x93NUMPY\x09\x00", DamagedFileError),
    ],
)
def test_refusals(data: bytes, error: type[Exception]) -> None:
    with pytest.raises(error):
        read_npy(data)
