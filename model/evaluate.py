"""Evaluation of the surrogate on surfaces it never saw: a table by grid size, and the model card that holds it."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from tqdm import tqdm

from model.dataset import DatasetConfig, build, read_pairs
from model.metrics import BOUNDARY_TOLERANCE, compare
from model.surrogate import Surrogate
from solver.resistance import boyer_resistance

TEST_SEED = 10_000_000
"""First surface seed of the test sets; training seeds stay below."""

SIZES = (32, 64, 128, 256, 512)


@dataclass(frozen=True)
class Row:
    """Agreement with the reference over the test maps of one size.

    Errors of area and resistance are relative; ``area_bias`` is the mean with its sign. ``expected_dice_error`` is the mean
    of what the predictions said of themselves, to be held against 1 - ``dice``.
    """

    size: int
    maps: int
    dice: float
    dice_5th_percentile: float
    jaccard: float
    bf_score: float
    pixel_accuracy: float
    area_error: float
    area_bias: float
    resistance_error: float
    expected_dice_error: float
    milliseconds: float


def evaluate(
    data: Path,
    report: Path,
    weights: Path | None = None,
    sizes: tuple[int, ...] = SIZES,
    count: int = 200,
    processes: int = 1,
) -> list[Row]:
    """Evaluate weights on random midpoint surfaces with loads of 10 to 50 N and the paper's material.

    Args:
        data: directory for the test sets, one a size, built if they are not there.
        report: Markdown file for the model card; the numbers go beside it as JSON.
        weights: directory of the weights; the shipped ones if left out.
        sizes: pixels a side.
        count: maps a size.
        processes: how many solve side by side where a test set must be built.
    """
    surrogate = Surrogate.load(weights) if weights else Surrogate.load()
    rows = []
    for size in sizes:
        directory = data / f"test{size}"
        build(directory, DatasetConfig(size=size, count=count, seed=TEST_SEED), processes)
        rows.append(_evaluate_size(surrogate, directory, size))
    report.parent.mkdir(parents=True, exist_ok=True)
    report.with_suffix(".json").write_text(
        json.dumps({"model": surrogate.version, "rows": [asdict(row) for row in rows]}, indent=2) + "\n", encoding="utf-8"
    )
    report.write_text(model_card(surrogate, rows), encoding="utf-8")
    return rows


def _evaluate_size(surrogate: Surrogate, directory: Path, size: int) -> Row:
    comparisons, resistance_errors, expected, seconds = [], [], [], []
    for problem, pressure in tqdm(read_pairs(directory), desc=f"evaluate {size}", unit="map"):
        reference = pressure > 0
        started = perf_counter()
        prediction = surrogate.predict(problem)
        seconds.append(perf_counter() - started)
        comparisons.append(compare(reference, prediction.contact_mask))
        resistances = [boyer_resistance(mask, problem.pixel_size, 1.0) for mask in (prediction.contact_mask, reference)]
        resistance_errors.append(abs(resistances[0] / resistances[1] - 1))
        expected.append(prediction.expected_error.dice)
    dice = np.array([c.dice for c in comparisons])
    area = np.array([c.area_error for c in comparisons])
    return Row(
        size=size,
        maps=len(comparisons),
        dice=float(dice.mean()),
        dice_5th_percentile=float(np.percentile(dice, 5)),
        jaccard=float(np.mean([c.jaccard for c in comparisons])),
        bf_score=float(np.mean([c.bf_score for c in comparisons])),
        pixel_accuracy=float(np.mean([c.pixel_accuracy for c in comparisons])),
        area_error=float(np.abs(area).mean()),
        area_bias=float(area.mean()),
        resistance_error=float(np.mean(resistance_errors)),
        expected_dice_error=float(np.mean(expected)),
        milliseconds=float(np.median(seconds) * 1e3),
    )


def table(rows: list[Row]) -> str:
    """The rows as a Markdown table."""
    lines = [
        "| size | maps | Dice | 5th percentile | Jaccard | BF | pixel accuracy | area error (bias) | resistance error "
        "| 1 - Dice, expected / found | median ms |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {r.size} | {r.maps} | {r.dice:.4f} | {r.dice_5th_percentile:.4f} | {r.jaccard:.4f} | {r.bf_score:.4f} "
        f"| {r.pixel_accuracy:.4f} | {r.area_error:.2%} ({r.area_bias:+.2%}) | {r.resistance_error:.2%} "
        f"| {r.expected_dice_error:.4f} / {1 - r.dice:.4f} | {r.milliseconds:.0f} |"
        for r in rows
    ]
    return "\n".join(lines) + "\n"


def model_card(surrogate: Surrogate, rows: list[Row]) -> str:
    """The model card: what the weights are, how they were made, and what they reach."""
    manifest = surrogate.weights.manifest
    training = manifest["training"]
    builds = "\n".join(f"    {_build_command(name, data)}" for name, data in manifest["datasets"].items())
    ends = [stage["first_epoch"] - 1 for stage in manifest["stages"][1:]] + [manifest["epochs"]]
    stages = "\n".join(
        f"    asperity train RUN {' '.join(f'--data {name}' for name in stage['data'])} --width {training['width']} "
        f"--alpha {training['alpha']:g} --batch {training['batch']} --learning-rate {training['learning_rate']:g} "
        f"--seed {training['seed']} --epochs {end}"
        for stage, end in zip(manifest["stages"], ends, strict=True)
    )
    return f"""# Model card: {surrogate.version}

Written by `asperity evaluate`; every number on this page comes from that command or from the manifest of the weights.

**What it is.** The U-Net of the paper (23 convolutional layers) with {training["width"]} feature maps in its first stage,
which predicts where a rough surface under a load touches a flat. Its input is dimensionless: the gap and the pressure of a
solve on a four times coarser grid, and the load (`model/features.py`). SHA-256 of the weights: `{manifest["sha256"]}`.

**Data.** Rough surfaces by random midpoint displacement, 1 mm square, heights 0 to 50 um, E* = 6.843 GPa, some with the
form, lay and noise of measured maps (`model/instrument.py`). Every tenth surface was held out for validation.

{builds}
{stages}

**Training.** {manifest["epochs"]} epochs; Dice on the held-out surfaces {manifest["validation"]["dice"]:.4f}.

**What it reaches** on surfaces it never saw (seeds from {TEST_SEED}; Hurst exponent 0.5, 10 to 50 N, free boundary,
E* = 6.843 GPa; BF tolerance {BOUNDARY_TOLERANCE} pixels; resistance by Boyer's formula on both masks). Times are of the
machine that wrote this page, features included.

{table(rows)}
**Where not to trust it.** Dimensionless loads outside log10 F / (E* A0 rms slope) =
{manifest["log_load_range"][0]:.2f} to {manifest["log_load_range"][1]:.2f} are answered with `in_distribution: false`.
Steps, machined grooves and isolated spikes are not in its training data: verify them.
"""


def _build_command(name: str, dataset: dict[str, Any]) -> str:
    """The command that builds a data set again, bit for bit."""
    return (
        f"asperity dataset {name} --size {dataset['size']} --count {dataset['count']} --seed {dataset['seed']} "
        f"--hurst {dataset['hurst_range'][0]:g} {dataset['hurst_range'][1]:g} "
        f"--load-n {dataset['load_range_n'][0]:g} {dataset['load_range_n'][1]:g} "
        f"--periodic-share {dataset['periodic_share']:g} --instrument-share {dataset['instrument_share']:g}"
    )
