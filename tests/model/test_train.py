import json
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from model import Surrogate
from model.dataset import DatasetConfig, build
from model.train import TrainConfig, train, turned


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> TrainConfig:
    data = tmp_path_factory.mktemp("train") / "data"
    build(data, DatasetConfig(size=32, count=40))
    return TrainConfig(data=(str(data),), width=4, batch=8, averaging=0.5, threads=1, epochs=4)


def history(run: Path) -> list[dict[str, float]]:
    return [json.loads(line) for line in (run / "history.jsonl").read_text().splitlines()]


def test_a_run_that_was_stopped_goes_on_as_if_it_had_not(config: TrainConfig, tmp_path: Path) -> None:
    train(tmp_path / "whole", config)
    train(tmp_path / "stopped", replace(config, epochs=2))
    train(tmp_path / "stopped", config)
    assert history(tmp_path / "stopped") == history(tmp_path / "whole")
    manifests = [json.loads((tmp_path / run / "weights/manifest.json").read_text()) for run in ("whole", "stopped")]
    assert manifests[0]["sha256"] == manifests[1]["sha256"]


def test_training_learns_and_its_weights_predict(config: TrainConfig, tmp_path: Path) -> None:
    train(tmp_path, replace(config, epochs=12, learning_rate=0.01))
    records = history(tmp_path)
    assert records[-1]["training_loss"] < 0.6 * records[0]["training_loss"]
    assert records[-1]["dice"] > 0.5
    checkpoint = torch.load(tmp_path / "checkpoint.pt", weights_only=True)
    assert checkpoint["config"]["width"] == 4
    surrogate = Surrogate.load(tmp_path / "weights")
    assert surrogate.version.startswith("unet4-")
    assert surrogate.weights.manifest["datasets"][config.data[0]]["size"] == 32


def test_rotations_turn_inputs_and_masks_together_in_all_eight_ways() -> None:
    picture = torch.arange(16.0).reshape(1, 4, 4)
    inputs, masks = picture.repeat(200, 1, 1, 1), picture.repeat(200, 1, 1)
    x, y = turned(inputs, masks, torch.Generator().manual_seed(0))
    torch.testing.assert_close(x[:, 0], y)
    assert len({tuple(image.flatten().tolist()) for image in y}) == 8


def test_other_data_begin_a_new_stage(config: TrainConfig, tmp_path: Path) -> None:
    more = tmp_path / "more"
    build(more, DatasetConfig(size=32, count=20, seed=500))
    train(tmp_path / "run", replace(config, epochs=2))
    train(tmp_path / "run", replace(config, epochs=3, data=(*config.data, str(more))))
    manifest = json.loads((tmp_path / "run/weights/manifest.json").read_text())
    assert manifest["epochs"] == 3
    assert [stage["first_epoch"] for stage in manifest["stages"]] == [1, 3]
    assert [data["count"] for data in manifest["datasets"].values()] == [40, 20]
