import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from model import Surrogate, compare
from model import evaluate as evaluation
from model.calibration import QUANTITIES
from model.dataset import DatasetConfig, read_pairs
from model.figures import radial_spectrum
from model.held_out import TEST_SEED, HeldOutSet, held_out_sets
from model.methods import METHODS, SOLVED, restored
from model.weights import MEASURED, SHIPPED

ONE_SET = HeldOutSet("by scale", "64 x 64", DatasetConfig(size=64, count=4, seed=TEST_SEED), 0.9)


@pytest.fixture
def weights(tmp_path: Path) -> Path:
    return Path(shutil.copytree(SHIPPED, tmp_path / "weights"))


def test_the_card_holds_what_the_weights_reach_and_what_it_costs(
    weights: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluation, "held_out_sets", lambda _: [ONE_SET])
    monkeypatch.setattr(evaluation, "MEASURED_SIZES", (32, 64))
    monkeypatch.setattr(evaluation, "MOST_SURFACES", 2)
    rows = evaluation.evaluate(tmp_path / "data", tmp_path / "card.md", weights)

    surrogate = Surrogate.load(weights)
    pairs = list(read_pairs(tmp_path / "data/by-scale-64-x-64"))
    (alone,), (served,) = rows["network alone"], rows["served, balanced"]
    dice = [compare(pressure > 0, surrogate.estimate(problem).contact_mask).dice for problem, pressure in pairs]
    assert alone.maps == served.maps == 4
    assert alone.dice == pytest.approx(np.mean(dice))
    assert alone.dice_5th_percentile == pytest.approx(np.percentile(dice, 5))
    assert alone.methods == {"surrogate": 4}
    assert served.dice > 0.98

    card = (tmp_path / "card.md").read_text()
    assert f"| by scale: 64 x 64 | 4 | {alone.dice:.4f} | 0.9 |" in card
    assert surrogate.version in card
    assert surrogate.weights.manifest["sha256"] in card
    assert json.loads((tmp_path / "card.json").read_text())["network alone"][0]["dice"] == alone.dice

    for name in ("scales", "loads", "areas", "by_scale", "by_load", "worst"):
        picture = Image.open(tmp_path / f"figures/{name}.png")
        assert min(picture.size) > 100
        assert f"(figures/{name}.png)" in card

    ways = restored((weights / MEASURED).read_text(), surrogate.weights.manifest["sha256"])
    assert ways
    assert {one.pixels for one in ways.measured} == {32**2, 64**2}
    assert {one.method for one in ways.measured} == set(METHODS)
    assert all(one.errors["dice"].expected < 1e-3 for one in ways.measured if one.method == SOLVED)
    assert all(fitted[quantity]["factor"] > 0 for fitted in (ways.network, ways.stopped) for quantity in QUANTITIES)


def test_no_training_surface_is_a_test_surface() -> None:
    seeds = [one.config.seed for one in held_out_sets(100)]
    for data in Surrogate.load().weights.manifest["datasets"].values():
        assert data["seed"] + data["count"] <= min(seeds)


def test_test_sets_share_no_surface_with_the_measured_ways_to_answer() -> None:
    for one in held_out_sets(1000):
        assert one.config.seed + one.config.count <= evaluation.MEASURED_SEED


def test_the_radial_spectrum_of_a_wave_is_at_its_frequency() -> None:
    """cos(2 pi 5 x / n) as a mask has its power at 5, and the mean of the mask at 0 (paper Eqs. 22-25)."""
    columns = np.arange(60)
    mask = np.broadcast_to(np.cos(2 * np.pi * 5 * columns / 60) > 0, (40, 60))
    spectrum = radial_spectrum(mask)
    assert len(spectrum) == 20
    assert spectrum[0] == pytest.approx(mask.sum() ** 2)
    assert spectrum[1:].argmax() + 1 == 5
