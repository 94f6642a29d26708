"""Stored results: a directory of files by id, written whole or not at all, and kept for a time."""

import re
import shutil
import time
from contextlib import suppress
from pathlib import Path
from uuid import uuid4

from worker.errors import ResultNotFoundError

PRUNE_EVERY_S = 3600.0
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
        """Store the files of a result; it appears with all of them at once."""
        self._prune()
        staging = self.root / f"{result_id}.new"
        staging.mkdir()
        for name, data in files.items():
            (staging / name).write_bytes(data)
        staging.rename(self.root / result_id)

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
