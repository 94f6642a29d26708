import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from model import Surrogate
from model import train as train_module
from model.dataset import DatasetConfig, Sample, Shard, add_shard, build
from model.errors import DatasetError, DivergedError
from model.features import Features, network_input
from model.prepared import prepare
from model.train import TrainConfig, train, turned
from model.weights import SHIPPED


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("train")
    build(directory / "32", DatasetConfig(size=32, count=60, family="varied"))
    build(directory / "64", DatasetConfig(size=64, count=20, seed=500))
    return directory


@pytest.fixture
def config(data: Path) -> TrainConfig:
    return TrainConfig(data=(str(data / "32"), str(data / "64")), epochs=2, averaging=0.5, checkpoint_every=3)


@pytest.fixture(autouse=True)
def small_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(train_module, "BATCH_PIXELS", 8 * 32**2)


def history(run: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (run / "history.jsonl").read_text().splitlines()]


def sha256(run: Path) -> str:
    return str(json.loads((run / "weights/manifest.json").read_text())["sha256"])


class StoppedError(Exception):
    pass


def test_a_run_that_was_stopped_goes_on_as_if_it_had_not(
    config: TrainConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    train(tmp_path / "whole", config)
    step, taken = train_module._step, 0

    def some_steps(*given: object) -> float:
        nonlocal taken
        taken += 1
        if taken > 8:
            raise StoppedError
        return step(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(train_module, "_step", some_steps)
    with pytest.raises(StoppedError):
        train(tmp_path / "stopped", config)
    monkeypatch.setattr(train_module, "_step", step)
    train(tmp_path / "stopped", config)
    assert history(tmp_path / "stopped")[-1]["step"] == history(tmp_path / "whole")[-1]["step"]
    assert sha256(tmp_path / "stopped") == sha256(tmp_path / "whole")


def test_a_run_that_diverges_says_so_and_keeps_its_checkpoint(
    config: TrainConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(train_module, "_step", lambda *given: float("nan"))
    with pytest.raises(DivergedError, match=r"learning rate below 0\.002"):
        train(tmp_path, config)
    assert not (tmp_path / "checkpoint.pt").exists()


def test_a_checkpoint_of_another_configuration_is_refused(config: TrainConfig, tmp_path: Path) -> None:
    train(tmp_path, replace(config, epochs=1))
    with pytest.raises(DatasetError, match="another configuration"):
        train(tmp_path, replace(config, epochs=1, seed=1))


def test_training_learns_and_its_weights_predict_and_are_trained_further(config: TrainConfig, tmp_path: Path) -> None:
    train(tmp_path / "first", replace(config, epochs=20, checkpoint_every=70))
    records = history(tmp_path / "first")
    assert records[-1]["loss"] < 0.5 * records[0]["loss"]  # type: ignore[operator]
    assert records[-1]["validation"]["32 x 32"]["dice"] > 0.5  # type: ignore[index]
    surrogate = Surrogate.load(tmp_path / "first/weights")
    assert sha256(tmp_path / "first").startswith(surrogate.version.split("-")[1])
    assert surrogate.weights.manifest["datasets"][config.data[0]]["size"] == 32

    train(tmp_path / "second", replace(config, epochs=1, learning_rate=1e-5, start=str(tmp_path / "first/weights")))
    assert history(tmp_path / "second")[0]["loss"] < 0.6 * records[0]["loss"]  # type: ignore[operator]
    first, second = Surrogate.load(tmp_path / "second/weights").weights.manifest["training"]
    assert (first["epochs"], first["start"]) == (20, None)
    assert (second["epochs"], second["start"]) == (1, surrogate.version)


def test_masks_of_another_solver_are_trained_on(tmp_path: Path) -> None:
    generator = np.random.default_rng(0)
    codes = generator.integers(0, 65535, (20, 24, 40)).astype(np.uint16)
    masks = (codes > np.quantile(codes, 0.95, axis=(1, 2), keepdims=True)).astype(np.float16)
    samples = [Sample(seed, 5.0, "free", 2.0, 3.0, 1.0, 100.0, pressure_known=False) for seed in range(20)]
    add_shard(tmp_path / "fem", Shard(samples[:12], codes[:12], masks[:12]))
    add_shard(tmp_path / "fem", Shard(samples[12:], codes[12:], masks[12:]))
    (grid,) = prepare([tmp_path / "fem"], processes=1)
    assert len(grid) == 20
    assert not grid.known.any()
    train(tmp_path / "run", TrainConfig(data=(str(tmp_path / "fem"),), epochs=1, start=str(SHIPPED)))
    assert Surrogate.load(tmp_path / "run/weights").weights.manifest["datasets"][str(tmp_path / "fem")] == {"count": 20}
    assert len(Surrogate.load(tmp_path / "run/weights").weights.manifest["datasets"]) > 1


def test_samples_that_do_not_go_together_are_refused(tmp_path: Path) -> None:
    sample = Sample(0, 5.0, "free", 2.0, 3.0, 1.0, 100.0)
    codes, pressure = np.zeros((1, 8, 8), np.uint16), np.ones((1, 8, 8), np.float16)
    for shard, message in (
        (Shard([sample, sample], codes, pressure), "2 samples"),
        (Shard([sample], codes, pressure.astype(np.float64)), "float64 pressures"),  # type: ignore[arg-type]
        (Shard([sample], codes, 0 * pressure), "no contact"),
    ):
        with pytest.raises(DatasetError, match=message):
            add_shard(tmp_path, shard)


def test_surfaces_are_split_by_their_seeds(data: Path) -> None:
    for grid in prepare([data / "32", data / "64"], processes=1):
        parts = {part: set(grid.seeds[grid.members(part)].tolist()) for part in ("training", "validation", "test")}
        assert sum(map(len, parts.values())) == len(grid) == len(set.union(*parts.values()))
        assert len(parts["training"]) == 0.8 * len(grid)


def test_features_in_memory_are_those_of_the_problems(data: Path) -> None:
    """Computed once with a batch of others, and put together again from codes."""
    from model.dataset import read_shard, shard_paths
    from model.features import features

    (path,) = shard_paths(data / "32")
    shard = read_shard(path)
    (grid,) = prepare([data / "32"], processes=1)
    for i in (0, 17, 59):
        alone = features([shard.samples[i].problem(shard.codes[i])])
        stored = grid.features(torch.tensor([i]))
        torch.testing.assert_close(stored.conditions, alone.conditions)
        torch.testing.assert_close(network_input(stored)[:, :2], network_input(alone)[:, :2], rtol=1e-2, atol=3e-2)


def test_maps_turn_with_their_pressures_in_all_eight_ways(data: Path) -> None:
    (grid,) = prepare([data / "64"], processes=1)
    given, pressure = grid.features(torch.tensor([3])), grid.pressure[3:4].float()
    overlap = (guessed_gap(given) < 0) == (pressure > 0)
    seen = set()
    for way in range(8):
        ways, pressures = turned(given, pressure, way)
        assert ((guessed_gap(ways) < 0) == (pressures > 0)).sum() == overlap.sum()
        seen.add(tuple(pressures.flatten().tolist()))
    assert len(seen) == 8


def guessed_gap(given: Features) -> torch.Tensor:
    return network_input(given)[:, 0]


def test_a_team_under_torchrun_learns_as_one(config: TrainConfig, tmp_path: Path) -> None:
    """Two processes on the processor; only one writes, and the weights predict."""
    command = [Path(sys.executable).with_name("torchrun"), "--standalone", "--nproc-per-node", "2", "--no-python"]
    data = [word for directory in config.data for word in ("--data", directory)]
    training = [Path(sys.executable).with_name("asperity"), "train", tmp_path, *data, "--epochs", "1"]
    done = subprocess.run(
        [*map(str, command), *map(str, training)],
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert len(history(tmp_path)) == 1
    assert Surrogate.load(tmp_path / "weights").weights.manifest["training"][-1]["epochs"] == 1
