"""`asperity dataset`, `train` and `evaluate`."""

import json
import re
from pathlib import Path

from model.train import TrainConfig
from tests.app.conftest import run

OPTIONS = ("epochs", "learning_rate", "seed")


def test_a_data_set_is_built_and_trained_on(tmp_path: Path) -> None:
    data, directory = tmp_path / "data", tmp_path / "run"
    built = run("dataset", data, "--size", "32", "--count", "10", "--load-n", "10", "20", "--hurst", "0.4", "0.8", "--png")
    assert built.returncode == 0, built.stderr
    samples = [json.loads(line) for line in (data / "samples.jsonl").read_text().splitlines()]
    assert len(samples) == 10
    assert all(10 <= sample["load_n"] <= 20 for sample in samples)
    trained = run("train", directory, "--data", data, "--epochs", "1")
    assert trained.returncode == 0, trained.stderr
    assert (directory / "weights" / "network.safetensors").exists()


def test_another_data_set_in_the_directory_is_bad_input(tmp_path: Path) -> None:
    assert run("dataset", tmp_path, "--size", "16", "--count", "1").returncode == 0
    done = run("dataset", tmp_path, "--size", "8", "--count", "1")
    assert done.returncode == 2
    assert "another size" in done.stderr


def test_the_help_of_train_tells_the_defaults() -> None:
    told = dict(re.findall(r"--([a-z-]+) .*\[default: \((.*)\)\]", run("train", "--help").stdout))
    assert told == {name.replace("_", "-"): str(getattr(TrainConfig(data=()), name)) for name in OPTIONS} | {"from": "none"}


def test_weights_that_are_missing_are_a_failure(tmp_path: Path) -> None:
    done = run("evaluate", "--data", tmp_path / "data", "--report", tmp_path / "card.md", "--weights", tmp_path)
    assert done.returncode == 1
    assert "missing" in done.stderr
