"""Error bars on surfaces that the surrogate was not trained on, measured ones and odd ones, against the full solve.

    asperity benchmark error-bars [DIRECTORY]

Odd ones are noise, spikes, terraces, a grating and a checkerboard; DIRECTORY holds measured maps and ``surfaces.json``
(name, png, pixel_size_x_um, pixel_size_y_um, height_range_um), pressed as they are and without their tilt. Loads are
10^-3.5 to 10^-1.2 of E* A0 rms slope. Each cell has the mean error found / expected, errors above one counted as one, and
how many were within the bound that nine in ten should be within.
"""

import json
import sys
from collections.abc import Iterator
from dataclasses import astuple, replace
from functools import partial
from pathlib import Path

import numpy as np
from tqdm import tqdm

from app.preparation import detrended
from app.uploads import decode
from benchmarks.cases import unlike_training
from model import Surrogate
from model.outcome import Outcome
from solver import ContactProblem, solve

LOG_LOADS = (-3.5, -2.5, -1.7, -1.2)
MODULUS = 1e11


def main() -> None:
    """Print a table, one kind of surface a row and way to answer."""
    surrogate = Surrogate.load()
    ways = {"network alone": surrogate.estimate} | {
        f"served, {word}": partial(surrogate.predict, accuracy=word) for word in ("fast", "balanced")
    }
    surfaces = [("odd", heights, (1e-6, 1e-6)) for heights in unlike_training().values()]
    if len(sys.argv) > 1:
        surfaces += _measured(Path(sys.argv[1]))
    problems = [(kind, problem) for kind, heights, pixel_size in surfaces for problem in _pressed(heights, pixel_size)]
    found: dict[tuple[str, str], list[Outcome]] = {}
    for kind, problem in tqdm(problems):
        reference = solve(problem).checked().contact_mask
        for name, way in ways.items():
            found.setdefault((kind, name), []).append(Outcome.of(problem, reference, way(problem), 0.0))
    print("| surfaces | answers | of | 1 - Dice | area | resistance |")
    print("|---|---|---|---|---|---|")
    for (kind, name), outcomes in found.items():
        print(f"| {kind} | {len(outcomes)} | {name} | {' | '.join(_cells(outcomes))} |")


def _measured(directory: Path) -> Iterator[tuple[str, np.ndarray, tuple[float, float]]]:
    for entry in json.loads((directory / "surfaces.json").read_text()):
        heights = decode((directory / entry["png"]).read_bytes()).values * (entry["height_range_um"] * 1e-6)
        pixel_size = entry["pixel_size_y_um"] * 1e-6, entry["pixel_size_x_um"] * 1e-6
        yield "measured, as they are", heights, pixel_size
        yield "measured, without tilt", detrended(heights, "plane"), pixel_size


def _pressed(heights: np.ndarray, pixel_size: tuple[float, float]) -> Iterator[ContactProblem]:
    problem = ContactProblem(heights, pixel_size, 1.0, MODULUS)
    for log_load in LOG_LOADS:
        yield replace(problem, load=10**log_load * MODULUS * problem.nominal_area * problem.rms_slope)


def _cells(outcomes: list[Outcome]) -> Iterator[str]:
    """Of 1 - Dice, area and resistance."""
    errors = np.minimum([outcome.errors for outcome in outcomes], 1.0).T
    bars = np.array([astuple(outcome.prediction.expected_error) for outcome in outcomes]).T
    for error, expected, bound in zip(errors, bars[:3], bars[3:], strict=True):
        yield f"{error.mean():.4f} / {expected.mean():.4f}, {np.mean(error <= bound):.0%}"


if __name__ == "__main__":
    main()
