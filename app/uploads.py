"""From the bytes of an upload to a height map: which format it is, said by its contents and never by its name."""

from app.errors import UnknownFormatError
from app.formats.npy import read_npy
from app.formats.png import SIGNATURE, read_png
from app.formats.table import looks_like_a_table, read_table
from app.formats.tiff import read_tiff
from app.height_map import HeightMap, checked

TIFF_SIGNATURES = (b"II*\x00", b"MM\x00*")
NPY_SIGNATURE = b"\x93NUMPY"


def is_png(data: bytes) -> bool:
    """Whether a file begins as a PNG does."""
    return len(data) > 0 and data.startswith(SIGNATURE[: len(data)])


def decode(data: bytes) -> HeightMap:
    """Decode a height map of any format that is read.

    Raises:
        UploadError: one of its subclasses; the message says what to change.
    """
    if not data:
        raise UnknownFormatError("The file is empty. Choose another, or export it again.")
    if is_png(data):
        return checked(read_png(data))
    if data.startswith(TIFF_SIGNATURES):
        return checked(read_tiff(data))
    if data.startswith(NPY_SIGNATURE):
        return checked(read_npy(data))
    if looks_like_a_table(data):
        return checked(read_table(data))
    from app.formats.instrument import read_instrument  # takes a second or two to import

    return checked(read_instrument(data))
