"""Stored results: a directory of files by id, written whole or not at all, and kept for a time."""

import errno
import re
import shutil
import time
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from uuid import uuid4

from worker.errors import ResultNotFoundError

PRUNE_EVERY_S = 3600.0
CLAIM = "claim"
_ID = re.compile(r"[0-9a-f]{32}")


def new_id() -> str:
    """An id for a result or a job: 32 hexadecimal digits."""
    return uuid4().hex


def is_id(text: str) -> bool:
    """Whether a text from outside could be an id of ours; only such a text may name a file or a key."""
    return _ID.fullmatch(text) is not None


class ResultStore:
    """Files by id and name.

    Args:
        root: directory, made if it is not there.
        retention_s: seconds after which an id is forgotten.
    """

    def __init__(self, root: Path, retention_s: float) -> None:
        self.root = root
        self.retention_s = retention_s
        self._pruned_at = 0.0
        root.mkdir(parents=True, exist_ok=True)

    def put(self, result_id: str, files: dict[str, bytes]) -> None:
        """Store the files of a result; it appears with all of them at once. One that is there already stays."""
        self._prune()
        staging = self.root / f"{result_id}.{new_id()}"
        staging.mkdir()
        for name, data in files.items():
            (staging / name).write_bytes(data)
        try:
            staging.rename(self.root / result_id)
        except OSError as error:
            shutil.rmtree(staging)
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise

    def replace(self, result_id: str, name: str, data: bytes) -> None:
        """Put another file in the place of one."""
        staging = self.root / result_id / new_id()
        staging.write_bytes(data)
        staging.replace(self.root / result_id / name)

    def claim(self, key: str, value: str) -> str:
        """Tie a value to a key that a client chose, for as long as results are kept; the first one tied to it stays."""
        claim_id = sha256(key.encode()).hexdigest()[:32]
        self.put(claim_id, {CLAIM: value.encode()})
        return self.get(claim_id, CLAIM).decode()

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
        for path in self.root.glob(f"*/{name}"):
            with suppress(FileNotFoundError):  # it has just been removed
                times[path.parent.name] = path.stat().st_mtime_ns
        ids = sorted(filter(is_id, times), key=lambda result_id: (times[result_id], result_id), reverse=True)
        if before is None:
            return ids[:count]
        if before not in times:
            raise ResultNotFoundError(f"There is no result {before} to go on from; begin again without it.")
        first = ids.index(before) + 1
        return ids[first : first + count]

    def get(self, result_id: str, name: str) -> bytes:
        """One file of a result.

        Raises:
            ResultNotFoundError: nothing of that id and name; ids that are not ours never reach the file system.
        """
        if not is_id(result_id):
            raise ResultNotFoundError(f"{result_id!r} is no id of a result; ids have 32 hexadecimal digits.")
        try:
            return (self.root / result_id / name).read_bytes()
        except FileNotFoundError as error:
            days = self.retention_s / 86400
            raise ResultNotFoundError(
                f"There is no result {result_id}, or it is gone: results are kept for {days:g} days."
            ) from error

    def _prune(self) -> None:
        """Remove what is past its retention, now and then."""
        now = time.time()
        if now - self._pruned_at < PRUNE_EVERY_S:
            return
        self._pruned_at = now
        for directory in self.root.iterdir():
            with suppress(FileNotFoundError):  # another request has just renamed or removed it
                if directory.stat().st_mtime < now - self.retention_s:
                    shutil.rmtree(directory, ignore_errors=True)
