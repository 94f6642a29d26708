"""Zip archives, honest and hostile."""

import io
import zipfile

import pytest

from app.archive import MOST_MEMBERS, Archive
from app.errors import ArchiveError


def zipped(files: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return file.getvalue()


def read(data: bytes, limit_bytes: int) -> dict[str, bytes]:
    archive = Archive(data, limit_bytes)
    return {info.filename: archive.read(info) for info in archive.files}


def test_files_come_in_their_order() -> None:
    files = {"b.png": b"one", "a/": b"", "a/x.png": b"two", "../../etc/passwd": b"three"}
    found = read(zipped(files), 100)
    assert found == {"b.png": b"one", "a/x.png": b"two", "../../etc/passwd": b"three"}


def bomb_with_a_lie() -> bytes:
    """A file that unpacks to 10 MB and says that it has 10 bytes."""
    data = bytearray(zipped({"a": bytes(10**7)}))
    for signature, offset in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        at = data.index(signature) + offset
        data[at : at + 4] = (10).to_bytes(4, "little")
    return bytes(data)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "cannot be read"),
        (b"PK\x03\x04 and so on", "cannot be read"),
        (zipped({"a": b"one"})[:-30], "cannot be read"),
        (zipped({}), "0 files"),
        (zipped({str(i): b"x" for i in range(MOST_MEMBERS + 1)}), f"{MOST_MEMBERS + 1} files"),
        (zipped({"bomb": bytes(10**7)}), "10000000 bytes unpacked"),
        (bomb_with_a_lie(), "cannot be read"),
    ],
)
def test_refusals(data: bytes, words: str) -> None:
    with pytest.raises(ArchiveError, match=words):
        read(data, 10**6)


@pytest.mark.parametrize("trick", ["plainly", "offset", "remark", "zip64"])
def test_a_list_of_very_many_files_is_not_read(trick: str) -> None:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for number in range(20_000):
            archive.writestr(str(number), b"")
        archive.comment = b"a remark" if trick == "remark" else b""
    data = bytearray(file.getvalue())
    if trick == "offset":
        data[-6:-2] = b"PK\x05\x06"
    if trick == "zip64":
        data[-10:-6] = (1000).to_bytes(4, "little")
        data[-22:-22] = b"PK\x06\x07" + bytes(16)
    with pytest.raises(ArchiveError, match="too many files"):
        Archive(bytes(data), 1000)
