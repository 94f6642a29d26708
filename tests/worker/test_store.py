"""Stored results, in a directory and in a place that fsspec knows."""

import os
import resource
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from worker.errors import DamagedResultError, ResultNotFoundError, StoreUnavailableError
from worker.store import ResultStore, new_id


@pytest.fixture(params=["directory", "memory"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    return f"memory://{tmp_path}" if request.param == "memory" else str(tmp_path / "results")


def test_what_is_put_is_got(place: str) -> None:
    result_id = new_id()
    ResultStore(place, retention_s=60).put(result_id, {"answer.json": b"{}", "mask.png": b"\x00\xff\n"})
    assert ResultStore(place, retention_s=60).get(result_id, "answer.json") == b"{}"
    assert ResultStore(place, retention_s=60).get(result_id, "mask.png") == b"\x00\xff\n"


@pytest.mark.parametrize("result_id", ["../../etc", "..", "", "/etc", "a" * 31, "A" * 32, "0" * 32, "0" * 31 + "\n"])
def test_foreign_ids_are_not_found(place: str, result_id: str) -> None:
    with pytest.raises(ResultNotFoundError):
        ResultStore(place, retention_s=60).get(result_id, "passwd")


def test_what_was_changed_behind_our_back_is_not_given_out(tmp_path: Path) -> None:
    store, result_id = ResultStore(tmp_path, retention_s=60), new_id()
    store.put(result_id, {"mask.png": b"a mask"})
    file = tmp_path / result_id / "mask.png"
    file.write_bytes(file.read_bytes()[:-1] + b"!")
    with pytest.raises(DamagedResultError, match=r"mask\.png"):
        store.get(result_id, "mask.png")


def test_a_place_that_refuses_says_so_and_keeps_nothing_half(tmp_path: Path) -> None:
    store, result_id = ResultStore(tmp_path, retention_s=60), new_id()
    store.put(result_id, {"answer.json": b"first"})
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, resource.RLIM_INFINITY))
    try:
        with pytest.raises(StoreUnavailableError, match="File too large"):
            store.put(result_id, {"answer.json": bytes(2000)})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
    assert store.get(result_id, "answer.json") == b"first"
    assert len(list((tmp_path / result_id).iterdir())) == 1


def test_what_is_put_again_takes_its_place(place: str) -> None:
    store, result_id = ResultStore(place, retention_s=60), new_id()
    store.put(result_id, {"answer.json": b"first", "mask.png": b"mask"})
    store.put(result_id, {"answer.json": b"second"})
    assert store.get(result_id, "answer.json") == b"second"
    assert store.get(result_id, "mask.png") == b"mask"


def test_many_threads_write_whole_files(place: str) -> None:
    store, ids = ResultStore(place, retention_s=60), [new_id() for _ in range(4)]

    def write(number: int) -> None:
        for _ in range(20):
            store.put(ids[number % 4], {"a": bytes([number]) * 10_000, "b": b"b"})

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(write, range(8)))
    for result_id in ids:
        assert len(set(store.get(result_id, "a"))) == 1


def test_a_key_belongs_to_the_first_that_claims_it(place: str) -> None:
    store = ResultStore(place, retention_s=60)
    assert store.claim("../a key", "one") == "one"
    assert store.claim("../a key", "two") == "one"
    assert store.claim("another", "two") == "two"


def test_results_are_listed_newest_first(place: str) -> None:
    store, ids = ResultStore(place, retention_s=60), [new_id() for _ in range(5)]
    for result_id in ids:
        store.put(result_id, {"mask.png": b""})
        time.sleep(0.01)
    store.put(new_id(), {"other": b""})
    store.claim("a key", "a value")
    assert store.newest("mask.png", 2, None) == [ids[4], ids[3]]
    assert store.newest("mask.png", 9, ids[3]) == [ids[2], ids[1], ids[0]]
    with pytest.raises(ResultNotFoundError):
        store.newest("mask.png", 2, new_id())


def test_results_are_forgotten_after_their_time(tmp_path: Path) -> None:
    old, new = new_id(), new_id()
    ResultStore(tmp_path, retention_s=60).put(old, {"mask.png": b"old", "answer.json": b"old"})
    for file in (tmp_path / old).iterdir():
        os.utime(file, (time.time() - 100, time.time() - 100))
    store = ResultStore(tmp_path, retention_s=60)
    store.put(new, {"mask.png": b"new"})
    assert store.get(new, "mask.png") == b"new"
    assert not (tmp_path / old).exists()
    with pytest.raises(ResultNotFoundError):
        store.get(old, "mask.png")
