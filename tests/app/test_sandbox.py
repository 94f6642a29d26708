"""Decoding in a child process: the same answers, and limits that hold."""

import io

import h5py
import numpy as np
import pytest

from app import sandbox
from app.errors import DecodingLimitError, ImageTooLargeError, UnknownFormatError, UploadError
from app.sandbox import Sandbox
from app.uploads import decode
from tests.app.files import surface_codes, surface_png


def npy(values: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


@pytest.fixture(scope="module")
def box() -> Sandbox:
    return Sandbox()


@pytest.mark.parametrize("data", [surface_png(), npy(surface_codes() * 1e-9), b"1,2\n3,4\n"], ids=["png", "npy", "csv"])
def test_the_child_says_what_the_parent_would(box: Sandbox, data: bytes) -> None:
    ours, theirs = decode(data), box.decode(data)
    np.testing.assert_array_equal(theirs.values, ours.values)
    known, said = ({name: value for name, value in vars(one).items() if name != "values"} for one in (ours, theirs))
    assert said == known


def test_refusals_come_back_with_their_words(box: Sandbox) -> None:
    with pytest.raises(UnknownFormatError, match="no format that is read"):
        box.decode(b"nothing that anyone knows")
    with pytest.raises(ImageTooLargeError, match="5000 x 2"):
        box.decode(b"1,2\n" * 5000)


def test_a_reader_that_hangs_is_ended(box: Sandbox, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sandbox, "SECONDS", 0.0)
    with pytest.raises(DecodingLimitError, match="takes more than"):
        box.decode(npy(np.random.default_rng(0).random((2000, 2000))))


def test_a_reader_that_wants_too_much_memory_is_stopped(box: Sandbox) -> None:
    """A file of some kilobytes that unpacks to 16 GB."""
    with pytest.raises(UploadError):
        box.decode(huge_hdf5())


def huge_hdf5() -> bytes:
    file = io.BytesIO()
    with h5py.File(file, "w") as root:
        root.create_dataset("heights", (4000, 4000, 130), "f8", chunks=(400, 400, 13), compression="gzip", fillvalue=1.0)
    return file.getvalue()
