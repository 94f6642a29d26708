"""Zip archives of height maps, read in memory and never unpacked to a disk."""

import io
import zipfile
import zlib

from app.errors import ArchiveError

MOST_MEMBERS = 500

END, END_BYTES, LONGEST_REMARK = b"PK\x05\x06", 22, 2**16
"""Where a zip file says how many bytes its list of files has."""

LOCATOR_64 = b"PK\x06\x07"
"""20 bytes before that in files whose list may be longer, or elsewhere."""

LONGEST_DIRECTORY = MOST_MEMBERS * 500
"""Bytes, with names and remarks of a few hundred each."""

UNREADABLE = (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError, OSError, ValueError)
"""What the standard library raises: RuntimeError for encrypted files, NotImplementedError for unusual compression."""


class Archive:
    """A zip file whose files are unpacked one at a time, when they are asked for.

    Args:
        data: the zip file.
        limit_bytes: largest file, unpacked.

    Raises:
        ArchiveError: no zip file, or one that holds too much.
    """

    def __init__(self, data: bytes, limit_bytes: int) -> None:
        _check_directory(data)
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(data))
        except UNREADABLE as error:
            raise _unreadable(error) from error
        self._limit_bytes = limit_bytes
        self.files = [info for info in self._archive.infolist() if not info.is_dir()]
        if not 0 < len(self.files) <= MOST_MEMBERS:
            raise ArchiveError(f"The archive holds {len(self.files)} files; it may hold 1 to {MOST_MEMBERS}.")
        for info in self.files:
            if info.file_size > limit_bytes:
                raise ArchiveError(f"{info.filename} has {info.file_size} bytes unpacked, more than an upload may have.")

    def read(self, info: zipfile.ZipInfo) -> bytes:
        """The contents of a file.

        Raises:
            ArchiveError: it is damaged or encrypted.
        """
        try:
            with self._archive.open(info) as file:
                return file.read(self._limit_bytes)
        except UNREADABLE as error:
            raise _unreadable(error) from error


def _check_directory(data: bytes) -> None:
    """Refuse a list of files that would take long to read; a file without any is left to the reader.

    Raises:
        ArchiveError: the list is longer than that of as many files as there may be.
    """
    # Where the reader looks first: at the very end, without a remark.
    plain = data[-END_BYTES:].startswith(END) and data.endswith(b"\0\0")
    end = len(data) - END_BYTES if plain else data.rfind(END, -END_BYTES - LONGEST_REMARK)
    length = int.from_bytes(data[end + 12 : end + 16], "little")
    if end >= 0 and (length > LONGEST_DIRECTORY or data[max(end - 20, 0) : max(end - 16, 0)] == LOCATOR_64):
        raise ArchiveError(f"The archive holds too many files; it may hold 1 to {MOST_MEMBERS}.")


def _unreadable(error: Exception) -> ArchiveError:
    return ArchiveError(f"The archive cannot be read ({error}). Send a plain zip file, without a password.")
