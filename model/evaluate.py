"""Evaluation of the surrogate: what every way to answer costs and how wrong it is, and what the surrogate reaches on
surfaces it never saw, the paper's numbers beside."""

import json
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import partial
from itertools import product
from pathlib import Path
from time import perf_counter

import numpy as np
from tqdm import tqdm

from model.calibration import COVERED, QUANTITIES, Calibration, ErrorBar, calibrated
from model.dataset import DatasetConfig, build, draw, read_pairs
from model.features import log_load
from model.figures import draw_figures
from model.held_out import HeldOutSet, held_out_sets
from model.methods import METHODS, NETWORK, SOLVED, Measured, Ways, stored
from model.model_card import model_card
from model.outcome import Outcome, Row
from model.prediction import Prediction
from model.surrogate import Surrogate
from model.weights import MEASURED, SHIPPED
from model.worst_cases import worst_cases
from solver.problem import BoolArray, ContactProblem
from solver.solve import solve

MEASURED_SIZES = (32, 64, 128, 256, 512, 1024)
MEASURED_LOADS_N = (0.5, 3.0, 30.0, 300.0)
MEASURED_SEED = 20_000_000
MOST_SURFACES, SURFACE_PIXELS = 8, 2**18
"""Surfaces of each kind, size and load on which the ways to answer are measured, and their pixels; at least two."""

SMOOTH_HURST = 0.8
"""Hurst exponent of the measured surfaces that are neither midpoint nor varied ones."""

FIGURES = "figures"
"""Folder beside the report for its pictures."""

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
    unmeasured = Surrogate.load(weights)
    ways = measure(unmeasured)
    (weights / MEASURED).write_text(stored(ways, unmeasured.weights.manifest["sha256"]), encoding="utf-8")
    surrogate = Surrogate.load(weights)
    sets = held_out_sets(count)
    for one in sets:
        build(_directory(data, one), one.config, processes)
    judged: dict[str, Way] = {"network alone": surrogate.estimate, "served, balanced": surrogate.predict}
    outcomes = {
        name: [_outcomes(way, _directory(data, one)) for one in tqdm(sets, desc=name)] for name, way in judged.items()
    }
    rows = {name: [Row.of(*pair) for pair in zip(sets, found, strict=True)] for name, found in outcomes.items()}
    report.parent.mkdir(parents=True, exist_ok=True)
    numbers = {"model": surrogate.version} | {name: [asdict(row) for row in found] for name, found in rows.items()}
    report.with_suffix(".json").write_text(json.dumps(numbers, indent=2) + "\n", encoding="utf-8")
    alone = list(zip(sets, outcomes["network alone"], strict=True))
    pictures = draw_figures(report.parent / FIGURES, alone)
    card = model_card(surrogate, rows, ways.measured, pictures, worst_cases(alone))
    report.write_text(card, encoding="utf-8")
    return rows


def measure(surrogate: Surrogate) -> Ways:
    """Cost and error of every way to answer, on surfaces that are in no other set: midpoint, varied and smooth ones."""
    measured: list[Measured] = []
    alone: list[Outcome] = []
    stopped: list[Outcome] = []
    for size, load in tqdm(list(product(MEASURED_SIZES, MEASURED_LOADS_N)), desc="ways to answer"):
        problems = _measured_problems(size, load)
        references = [solve(problem).checked().contact_mask for problem in problems]
        for method in METHODS:
            way = partial(surrogate.answer, method=method)
            outcomes = [_outcome(way, *pair) for pair in zip(problems, references, strict=True)]
            found_errors = np.array([outcome.errors for outcome in outcomes])
            errors = {
                quantity: ErrorBar(float(values.mean()), float(np.quantile(values, COVERED)))
                for quantity, values in zip(QUANTITIES, found_errors.T, strict=True)
            }
            milliseconds = float(np.median([outcome.milliseconds for outcome in outcomes]))
            measured.append(Measured(method, size**2, log_load(problems[0]), milliseconds, errors))
            if method == NETWORK:
                alone += outcomes
            elif method != SOLVED:
                stopped += outcomes
    return Ways(tuple(measured), _calibration(alone), _calibration(stopped))


def _calibration(outcomes: list[Outcome]) -> Calibration:
    by_quantity = zip(*(outcome.errors for outcome in outcomes), strict=True)
    wrong_by = dict(zip(QUANTITIES, by_quantity, strict=True))
    return calibrated([outcome.prediction.evidence for outcome in outcomes], wrong_by)


def _measured_problems(size: int, load: float) -> list[ContactProblem]:
    """Midpoint surfaces under a load, and others under the same dimensionless load."""
    count = min(MOST_SURFACES, max(2, SURFACE_PIXELS // size**2))
    midpoint = DatasetConfig(size=size, seed=MEASURED_SEED, load_range_n=(load, load))
    smooth = replace(midpoint, hurst_range=(SMOOTH_HURST, SMOOTH_HURST))
    others = (replace(midpoint, family="varied"), replace(smooth, family="anisotropic"), replace(smooth, family="skewed"))
    problems = [one.problem for one in draw(midpoint, range(count))]
    for config in others:
        for first in range(count):
            (drawn,) = draw(config, range(first, first + 1))
            factor = 10 ** (log_load(problems[0]) - log_load(drawn.problem))
            problems.append(replace(drawn.problem, load=drawn.problem.load * factor))
    return problems


def _outcomes(way: Way, directory: Path) -> list[Outcome]:
    return [_outcome(way, problem, pressure > 0) for problem, pressure in read_pairs(directory)]


def _outcome(way: Way, problem: ContactProblem, reference: BoolArray) -> Outcome:
    """A prediction, judged; its time is the better of two."""
    times = []
    for _ in range(2):
        started = perf_counter()
        prediction = way(problem)
        times.append(perf_counter() - started)
    return Outcome.of(problem, reference, prediction, min(times) * 1e3)


def _directory(data: Path, held_out: HeldOutSet) -> Path:
    return data / f"{held_out.group} {held_out.name}".replace(",", "").replace(" ", "-")
