from pathlib import Path

import pytest
from redis import Redis

from model.dataset import DatasetConfig, build, fill
from model.errors import DatasetError
from tests.worker.conftest import worker
from worker.settings import Settings
from worker.shards import ShardQueue

CONFIG = DatasetConfig(size=32, count=6, family="varied")


def contents(directory: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in directory.iterdir()}


def test_workers_build_the_same_bits(
    connection: Redis,
    settings: Settings,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("model.dataset.SHARD", 2)
    build(tmp_path / "here", CONFIG)
    queue = ShardQueue(connection, settings)
    with worker(settings):
        fill(tmp_path / "there", CONFIG, queue)
    assert contents(tmp_path / "there") == contents(tmp_path / "here")
    assert queue.queue.count == 0
    assert not connection.keys("asperity:shard:*")


def test_what_a_worker_cannot_make_is_told(connection: Redis, settings: Settings, tmp_path: Path) -> None:
    """A size that no midpoint surface has."""
    with worker(settings), pytest.raises(DatasetError, match=r"could not make shard 0: .*power of two"):
        fill(tmp_path, DatasetConfig(size=20, count=2), ShardQueue(connection, settings))
