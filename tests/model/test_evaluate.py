import json
from pathlib import Path

import numpy as np
import pytest

from model import Surrogate, compare
from model.dataset import read_pairs
from model.evaluate import TEST_SEED, evaluate


def test_the_card_holds_what_the_weights_reach_on_unseen_surfaces(tmp_path: Path) -> None:
    (row,) = evaluate(tmp_path / "data", tmp_path / "card.md", sizes=(64,), count=4)
    surrogate = Surrogate.load()
    dice = [
        compare(mask, surrogate.predict(problem).contact_mask).dice for problem, mask in read_pairs(tmp_path / "data/test64")
    ]
    assert row.maps == 4
    assert row.dice == pytest.approx(np.mean(dice))
    assert row.dice_5th_percentile == pytest.approx(np.percentile(dice, 5))
    card = (tmp_path / "card.md").read_text()
    assert f"{row.dice:.4f}" in card
    assert surrogate.version in card
    assert surrogate.weights.manifest["sha256"] in card
    assert json.loads((tmp_path / "card.json").read_text())["rows"][0]["dice"] == row.dice


def test_no_training_surface_is_a_test_surface() -> None:
    for data in Surrogate.load().weights.manifest["datasets"].values():
        assert data["seed"] + data["count"] <= TEST_SEED
