"""Evaluation of the surrogate: what every way to answer costs and how wrong it is, and what the surrogate reaches on
surfaces it never saw, the paper's numbers beside."""

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from itertools import product
from pathlib import Path
from time import perf_counter

import numpy as np
from tqdm import tqdm

from model.calibration import COVERED, QUANTITIES, ErrorBar
from model.dataset import DatasetConfig, build, draw, read_pairs
from model.features import log_load
from model.held_out import HeldOutSet, held_out_sets
from model.methods import METHODS, Choice, Measured, stored
from model.metrics import compare
from model.model_card import model_card
from model.rows import Row
from model.surrogate import EXACT, Prediction, Surrogate
from model.weights import MEASURED, SHIPPED
from solver.problem import BoolArray, ContactProblem
from solver.resistance import boyer_resistance
from solver.solve import solve

MEASURED_SIZES = (32, 64, 128, 256, 512, 1024)
MEASURED_LOADS_N = (3.0, 30.0, 300.0)
MEASURED_SEED = 20_000_000
SURFACES = 4
"""Surfaces of each size and load on which the ways to answer are measured."""

Way = Callable[[ContactProblem], Prediction]


def evaluate(
    data: Path, report: Path, weights: Path = SHIPPED, count: int = 100, processes: int = 1
) -> dict[str, list[Row]]:
    """Measure the ways to answer, then the surrogate on the test sets.

    Args:
        data: directory for the test sets, built where they are missing.
        report: Markdown file for the model card; the numbers go beside it as JSON.
        weights: directory of the weights, which gets ``methods.json`` too; the shipped ones if left out.
        count: maps of a test set of 128 x 128.
        processes: how many solve side by side where a test set must be built.

    Returns:
        Rows of the network alone and of the served answer (``balanced``).
    """
    measured = measure(Surrogate.load(weights))
    (weights / MEASURED).write_text(stored(measured), encoding="utf-8")
    surrogate = Surrogate.load(weights)
    sets = held_out_sets(count)
    for one in sets:
        build(_directory(data, one), one.config, processes)
    ways: dict[str, Way] = {"network alone": surrogate.estimate, "served, balanced": surrogate.predict}
    rows = {name: [_row(way, data, one) for one in tqdm(sets, desc=name)] for name, way in ways.items()}
    report.parent.mkdir(parents=True, exist_ok=True)
    numbers = {"model": surrogate.version} | {name: [asdict(row) for row in found] for name, found in rows.items()}
    report.with_suffix(".json").write_text(json.dumps(numbers, indent=2) + "\n", encoding="utf-8")
    report.write_text(model_card(surrogate, rows, measured), encoding="utf-8")
    return rows


def measure(surrogate: Surrogate) -> list[Measured]:
    """Cost and error of every way to answer, on midpoint surfaces that are in no other set."""
    found = []
    for size, load in tqdm(list(product(MEASURED_SIZES, MEASURED_LOADS_N)), desc="ways to answer"):
        config = DatasetConfig(size=size, seed=MEASURED_SEED, load_range_n=(load, load))
        problems = [one.problem for one in draw(config, range(SURFACES))]
        references = [solve(problem).contact_mask for problem in problems]
        loads = float(np.mean([log_load(problem) for problem in problems]))
        for method in METHODS:
            comparisons, times = [], []
            for problem, reference in zip(problems, references, strict=True):
                prediction, milliseconds = _timed(partial(surrogate.answer, choice=Choice(method, 0.0, EXACT)), problem)
                comparisons.append(_errors(problem, reference, prediction.contact_mask))
                times.append(milliseconds)
            errors = {
                quantity: ErrorBar(float(np.mean(values)), float(np.quantile(values, COVERED)))
                for quantity, values in zip(QUANTITIES, zip(*comparisons, strict=True), strict=True)
            }
            found.append(Measured(method, size**2, loads, float(np.median(times)), errors))
    return found


def _timed(way: Way, problem: ContactProblem) -> tuple[Prediction, float]:
    """A prediction and its time in ms, the better of two."""
    times = []
    for _ in range(2):
        started = perf_counter()
        prediction = way(problem)
        times.append(perf_counter() - started)
    return prediction, min(times) * 1e3


def _errors(problem: ContactProblem, reference: BoolArray, mask: BoolArray) -> tuple[float, float, float]:
    """1 - Dice and the relative errors of area and resistance, as in ``QUANTITIES``."""
    comparison = compare(reference, mask)
    ratio = boyer_resistance(mask, problem.pixel_size, 1.0) / boyer_resistance(reference, problem.pixel_size, 1.0)
    return 1 - comparison.dice, abs(comparison.area_error), abs(ratio - 1)


def _row(way: Way, data: Path, held_out: HeldOutSet) -> Row:
    comparisons, errors, predictions, times = [], [], [], []
    for problem, pressure in read_pairs(_directory(data, held_out)):
        reference = pressure > 0
        prediction, milliseconds = _timed(way, problem)
        comparisons.append(compare(reference, prediction.contact_mask))
        errors.append(_errors(problem, reference, prediction.contact_mask))
        predictions.append(prediction)
        times.append(milliseconds)
    dice = np.array([comparison.dice for comparison in comparisons])
    area = np.array([comparison.area_error for comparison in comparisons])
    return Row(
        group=held_out.group,
        name=held_out.name,
        paper=held_out.paper,
        maps=len(comparisons),
        dice=float(dice.mean()),
        dice_5th_percentile=float(np.percentile(dice, 5)),
        jaccard=float(np.mean([comparison.jaccard for comparison in comparisons])),
        bf_score=float(np.mean([comparison.bf_score for comparison in comparisons])),
        pixel_accuracy=float(np.mean([comparison.pixel_accuracy for comparison in comparisons])),
        area_error=float(np.abs(area).mean()),
        area_bias=float(area.mean()),
        resistance_error=float(np.mean([error[2] for error in errors])),
        expected=float(np.mean([prediction.expected_error.dice for prediction in predictions])),
        covered=float(np.mean([1 - d <= p.expected_error.dice_bound for d, p in zip(dice, predictions, strict=True)])),
        milliseconds=float(np.median(times)),
        methods=dict(Counter(prediction.method for prediction in predictions)),
    )


def _directory(data: Path, held_out: HeldOutSet) -> Path:
    return data / f"{held_out.group} {held_out.name}".replace(",", "").replace(" ", "-")
