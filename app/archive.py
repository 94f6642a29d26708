"""Zip archives of height maps, read in memory and never unpacked to a disk."""

import io
import zipfile
import zlib
from collections.abc import Iterator

from app.errors import ArchiveError

MOST_MEMBERS = 500


def members(data: bytes, limit_bytes: int) -> Iterator[tuple[str, bytes]]:
    """Names and contents of the files of an archive, in its order.

    Args:
        data: a zip file.
        limit_bytes: largest file, unpacked.

    Raises:
        ArchiveError: no zip file, a damaged or encrypted one, or one that holds too much.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            files = [info for info in archive.infolist() if not info.is_dir()]
            if not 0 < len(files) <= MOST_MEMBERS:
                raise ArchiveError(f"The archive holds {len(files)} files; it may hold 1 to {MOST_MEMBERS}.")
            for info in files:
                if info.file_size > limit_bytes:
                    raise ArchiveError(f"{info.filename} has {info.file_size} bytes unpacked, more than an upload may have.")
            for info in files:
                with archive.open(info) as file:
                    yield info.filename, file.read(limit_bytes)
    except (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError, OSError, ValueError) as error:
        raise ArchiveError(f"The archive cannot be read ({error}). Send a plain zip file, without a password.") from error
