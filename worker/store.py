"""Stored results: files by id and name, in a directory or an object store, checked when they are read, kept for a time."""

import re
import time
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from uuid import uuid4

import fsspec

from worker.errors import DamagedResultError, ResultNotFoundError, StoreUnavailableError

PRUNE_EVERY_S = 3600.0
CLAIM = "claim"
DIGITS = 64
"""Of the hash that a file begins with; a line feed and the data follow."""

_ID = re.compile(r"[0-9a-f]{32}")


def new_id() -> str:
    """An id for a result or a job: 32 hexadecimal digits."""
    return uuid4().hex


def is_id(text: str) -> bool:
    """Whether a text from outside could be an id of ours; only such a text may name a file or a key."""
    return _ID.fullmatch(text) is not None


class ResultStore:
    """Files by id and name. Each is written whole or not at all.

    Args:
        root: a directory, made if it is not there, or the URL of a place that fsspec knows, such as ``s3://bucket/results``.
        retention_s: seconds after which an id is forgotten.
    """

    def __init__(self, root: Path | str, retention_s: float) -> None:
        self.files, self.root = fsspec.core.url_to_fs(str(root), auto_mkdir=True)
        self.retention_s = retention_s
        self._pruned_at = 0.0
        self.files.makedirs(self.root, exist_ok=True)

    def put(self, result_id: str, files: dict[str, bytes]) -> None:
        """Store the files of a result, in their order: whoever finds the last one finds them all.

        Raises:
            StoreUnavailableError: the place is full, or out of reach.
        """
        self._prune()
        for name, data in files.items():
            path = self._path(result_id, name)
            unfinished = f"{path}.{new_id()}"
            try:
                self.files.pipe_file(unfinished, sha256(data).hexdigest().encode() + b"\n" + data)
                self.files.mv(unfinished, path)
            except OSError as error:
                with suppress(OSError):
                    self.files.rm(unfinished)
                raise StoreUnavailableError.of(error) from error

    def get(self, result_id: str, name: str) -> bytes:
        """One file of a result.

        Raises:
            ResultNotFoundError: nothing of that id and name; ids that are not ours never reach the file system.
            DamagedResultError: it is not what was stored.
            StoreUnavailableError: the place is out of reach.
        """
        if not is_id(result_id):
            raise ResultNotFoundError(f"{result_id!r} is no id of a result; ids have 32 hexadecimal digits.")
        try:
            stored: bytes = self.files.cat_file(self._path(result_id, name))
        except FileNotFoundError as error:
            days = self.retention_s / 86400
            raise ResultNotFoundError(
                f"There is no result {result_id}, or it is gone: results are kept for {days:g} days."
            ) from error
        except OSError as error:
            raise StoreUnavailableError.of(error) from error
        digest, data = stored[:DIGITS], stored[DIGITS + 1 :]
        if sha256(data).hexdigest().encode() != digest:
            raise DamagedResultError(f"The file {name} of the result {result_id} is damaged; delete it, and ask again.")
        return data

    def claim(self, key: str, value: str) -> str:
        """Tie a value to a key that a client chose, for as long as results are kept; the first one tied to it stays."""
        claim_id = sha256(key.encode()).hexdigest()[: len(new_id())]
        with suppress(ResultNotFoundError):
            return self.get(claim_id, CLAIM).decode()
        self.put(claim_id, {CLAIM: value.encode()})
        return value

    def newest(self, name: str, count: int, before: str | None) -> list[str]:
        """Ids of results that have a file of that name, from the newest to the oldest.

        Args:
            name: of a file.
            count: at most.
            before: an id, older ones than which are wanted; None to begin with the newest.

        Raises:
            ResultNotFoundError: there is no such id to begin from.
        """
        times = {}
        for path in self.files.glob(f"{self.root}/*/{name}"):
            with suppress(FileNotFoundError):  # it has just been removed
                times[path.rsplit("/", 2)[1]] = self.files.modified(path)
        ids = sorted(filter(is_id, times), key=lambda result_id: (times[result_id], result_id), reverse=True)
        if before is None:
            return ids[:count]
        if before not in times:
            raise ResultNotFoundError(f"There is no result {before} to go on from; begin again without it.")
        first = ids.index(before) + 1
        return ids[first : first + count]

    def _path(self, result_id: str, name: str) -> str:
        return f"{self.root}/{result_id}/{name}"

    def _prune(self) -> None:
        """Remove what is past its retention, now and then."""
        now = time.time()
        if now - self._pruned_at < PRUNE_EVERY_S:
            return
        self._pruned_at = now
        newest: dict[str, float] = {}
        for path in self.files.glob(f"{self.root}/*/*"):
            place = path.rsplit("/", 1)[0]
            with suppress(FileNotFoundError):  # another service has just removed it
                newest[place] = max(newest.get(place, 0.0), self.files.modified(path).timestamp())
        for place, modified in newest.items():
            if modified < now - self.retention_s:
                with suppress(FileNotFoundError):
                    self.files.rm(place, recursive=True)
