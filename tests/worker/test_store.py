import os
import time
from pathlib import Path

import pytest

from worker.errors import ResultNotFoundError
from worker.store import ResultStore, new_id


def test_what_is_put_is_got(tmp_path: Path) -> None:
    store = ResultStore(tmp_path / "results", retention_s=60)
    result_id = new_id()
    store.put(result_id, {"answer.json": b"{}", "mask.png": b"\x00\xff"})
    assert store.get(result_id, "answer.json") == b"{}"
    assert ResultStore(tmp_path / "results", retention_s=60).get(result_id, "mask.png") == b"\x00\xff"


@pytest.mark.parametrize("result_id", ["../../etc", "..", "", "/etc", "a" * 31, "A" * 32, "0" * 32, "0" * 31 + "\n"])
def test_foreign_ids_are_not_found(tmp_path: Path, result_id: str) -> None:
    (tmp_path / "passwd").write_text("secret")
    with pytest.raises(ResultNotFoundError):
        ResultStore(tmp_path / "results", retention_s=60).get(result_id, "passwd")


def test_results_are_forgotten_after_their_time(tmp_path: Path) -> None:
    old, new = new_id(), new_id()
    ResultStore(tmp_path, retention_s=60).put(old, {"mask.png": b"old"})
    os.utime(tmp_path / old, (time.time() - 100, time.time() - 100))
    store = ResultStore(tmp_path, retention_s=60)
    store.put(new, {"mask.png": b"new"})
    assert store.get(new, "mask.png") == b"new"
    with pytest.raises(ResultNotFoundError):
        store.get(old, "mask.png")
