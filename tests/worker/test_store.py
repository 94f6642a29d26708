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


def test_what_is_there_stays(tmp_path: Path) -> None:
    store, result_id = ResultStore(tmp_path, retention_s=60), new_id()
    store.put(result_id, {"answer.json": b"first"})
    store.put(result_id, {"answer.json": b"second"})
    assert store.get(result_id, "answer.json") == b"first"
    assert [path.name for path in tmp_path.iterdir()] == [result_id]
    store.replace(result_id, "answer.json", b"third")
    assert store.get(result_id, "answer.json") == b"third"


def test_a_key_belongs_to_the_first_that_claims_it(tmp_path: Path) -> None:
    store = ResultStore(tmp_path, retention_s=60)
    assert store.claim("../a key", "one") == "one"
    assert store.claim("../a key", "two") == "one"
    assert store.claim("another", "two") == "two"


def test_results_are_listed_newest_first(tmp_path: Path) -> None:
    store, ids = ResultStore(tmp_path, retention_s=60), [new_id() for _ in range(5)]
    for result_id in ids:
        store.put(result_id, {"mask.png": b""})
        time.sleep(0.01)
    store.put(new_id(), {"other": b""})
    store.claim("a key", "a value")
    assert store.newest("mask.png", 2, None) == [ids[4], ids[3]]
    assert store.newest("mask.png", 9, ids[3]) == [ids[2], ids[1], ids[0]]
    with pytest.raises(ResultNotFoundError):
        store.newest("mask.png", 2, new_id())
