"""Fine-tuning on crops of one measured height map, judged on another part of it.

    asperity benchmark fine-tuning DIRECTORY NAME [EPOCHS]

DIRECTORY holds the maps and ``surfaces.json`` as for real-maps. Crops of 64 x 64 pixels of its left three fifths, solved
under loads from a thousandth to a fifth of E* A0 rms slope, are stored as pairs in the format of docs/data.md and trained on
from the shipped weights, as `asperity train --from` does; crops of the right two fifths are predicted before and after, and
random midpoint surfaces too, to see what was forgotten.
"""

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from app.uploads import decode
from benchmarks.cases import midpoint_problem
from model import Surrogate, compare
from model.dataset import Sample, Shard, add_shard, scaled_pressure
from model.families import CODES
from model.train import TrainConfig, train
from model.weights import SHIPPED
from solver import solve

SIDE = 64
LEFT = 0.6
COUNT, JUDGED = 400, 60
LOADS = (1e-3, 0.2)
MODULUS_GPA = 100.0
EPOCHS, RATE = 30, 5e-4
SEED = 60_000_000


def main() -> None:
    """Print a table."""
    directory, name = Path(sys.argv[1]), sys.argv[2]
    epochs = int(sys.argv[3]) if len(sys.argv) > 3 else EPOCHS
    (entry,) = (one for one in json.loads((directory / "surfaces.json").read_text()) if one["name"] == name)
    codes = np.rint(decode((directory / entry["png"]).read_bytes()).values * CODES).astype(np.uint16)
    border = int(LEFT * codes.shape[1])
    generator = np.random.default_rng(SEED)
    training = [_drawn(codes[:, :border], entry, 10 * i + i % 10, generator) for i in range(COUNT)]
    judged = [_drawn(codes[:, border:], entry, i, generator) for i in range(JUDGED)]
    with TemporaryDirectory() as scratch:
        data, run = Path(scratch) / "pairs", Path(scratch) / "run"
        add_shard(data, _solved(training))
        train(run, TrainConfig(data=(str(data),), epochs=epochs, learning_rate=RATE, start=str(SHIPPED)))
        networks = {"shipped": Surrogate.load(), "fine-tuned": Surrogate.load(run / "weights")}
    midpoint = [midpoint_problem(128, 30.0, seed=SEED + i) for i in range(20)]
    sets = {f"{name}, other part": [sample.problem(crop) for sample, crop in judged], "random midpoint, 128 x 128": midpoint}
    print(f"| network alone, Dice (lowest) | {' | '.join(networks)} |")
    print("|---|---|---|")
    for title, problems in sets.items():
        references = [solve(problem).checked().contact_mask for problem in problems]
        cells = []
        for surrogate in networks.values():
            masks = [surrogate.estimate(problem).contact_mask for problem in problems]
            dice = [compare(*pair).dice for pair in zip(references, masks, strict=True)]
            cells.append(f"{np.mean(dice):.4f} ({np.min(dice):.4f})")
        print(f"| {title} | {' | '.join(cells)} |", flush=True)


def _drawn(
    codes: np.ndarray, entry: dict[str, float], seed: int, generator: np.random.Generator
) -> tuple[Sample, np.ndarray]:
    """A crop under a load; training, validation and test are told apart by the last digit of the seed."""
    row, column = (int(generator.integers(side - SIDE + 1)) for side in codes.shape)
    crop = codes[row : row + SIDE, column : column + SIDE]
    units = {name: entry[name] for name in ("pixel_size_x_um", "pixel_size_y_um", "height_range_um")}
    sample = Sample(seed, 1.0, "free", effective_modulus_gpa=MODULUS_GPA, **units)
    problem = sample.problem(crop)
    share = np.exp(generator.uniform(*np.log(LOADS)))
    load = share * problem.effective_modulus * problem.nominal_area * problem.rms_slope
    return Sample(seed, float(load), "free", effective_modulus_gpa=MODULUS_GPA, **units), crop


def _solved(drawn: list[tuple[Sample, np.ndarray]]) -> Shard:
    """The crops with their pressures, in units of E* rms slope."""
    problems = [sample.problem(crop) for sample, crop in drawn]
    pressures = [scaled_pressure(problem, solve(problem).checked().pressure) for problem in problems]
    return Shard([sample for sample, _ in drawn], np.stack([crop for _, crop in drawn]), np.stack(pressures))


if __name__ == "__main__":
    main()
