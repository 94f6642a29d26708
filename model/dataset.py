"""Data sets: random midpoint surfaces and their contact masks, solved and stored as PNG files with their units.

A directory holds ``dataset.json`` (the configuration), ``samples.jsonl`` (one line a sample, in order) and, for each sample,
a 16-bit grey height map and a 1-bit contact mask. The same configuration gives the same files; a build that was stopped
goes on where it ended.
"""

import json
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from tqdm import tqdm

from model.errors import DatasetError
from model.instrument import LOG_LOAD_RANGE, as_measured, pixel_aspect
from solver.arrays import Device
from solver.midpoint import random_midpoint_displacement
from solver.problem import BoolArray, Boundary, ContactProblem
from solver.solution import Solution, Status
from solver.solve import solve_batch

CODES = 65535
"""Highest code of a 16-bit height map; code 0 is the lowest height, CODES the highest."""

BATCH, BATCH_PIXELS = 16, 2**18
"""Most surfaces, and pixels, that are solved side by side on the processor; more would not stay in its cache."""

COMPRESSION = 1
"""Of height maps: noise hardly packs, and higher levels take longer than the solve."""

DEVICE_BATCH_PIXELS = 2**24
"""Those on an accelerator, enough to keep it busy."""


@dataclass(frozen=True)
class DatasetConfig:
    """What a data set contains; the defaults are the paper's test surfaces with the material of its figures.

    Attributes:
        size: pixels a side, a power of two.
        count: number of samples.
        seed: first surface seed; sample i has seed + i.
        hurst_range: Hurst exponents are uniform in this range.
        load_range_n: loads are log-uniform in this range, in N.
        periodic_share: share of samples with the periodic boundary, the others are free.
        instrument_share: share of samples with the form, lay and noise of measured maps (``model/instrument.py``); these
            have loads of their own, relative to their slope, and pixels that need not be square.
        side_mm: side of the square.
        height_range_um: lowest to highest height.
        effective_modulus_gpa: E*.
        tolerance: of the solver.
    """

    size: int = 128
    count: int = 100
    seed: int = 0
    hurst_range: tuple[float, float] = (0.5, 0.5)
    load_range_n: tuple[float, float] = (10.0, 50.0)
    periodic_share: float = 0.0
    instrument_share: float = 0.0
    side_mm: float = 1.0
    height_range_um: float = 50.0
    effective_modulus_gpa: float = 6.843
    tolerance: float = 1e-6


@dataclass(frozen=True)
class Sample:
    """One line of ``samples.jsonl``: all that is needed to upload the height map or to read the mask."""

    heights: str
    mask: str
    seed: int
    hurst: float
    load_n: float
    boundary: Boundary
    pixel_size_x_um: float
    pixel_size_y_um: float
    height_range_um: float
    effective_modulus_gpa: float
    tolerance: float
    status: str
    residual: float
    contact_fraction: float


def build(directory: Path, config: DatasetConfig, processes: int = 1, device: Device = None) -> None:
    """Build a data set, or the rest of one that was stopped.

    Args:
        directory: made if it is not there.
        config: what to build; a larger count than before extends the data set.
        processes: how many solve side by side.
        device: of torch, such as ``cuda``, to solve on; None for the processor. Its rounding differs from the processor's.

    Raises:
        DatasetError: the directory holds a data set of another configuration.
    """
    directory.mkdir(parents=True, exist_ok=True)
    _claim(directory, config)
    samples = directory / "samples.jsonl"
    done = _complete_lines(samples)
    # Samples are solved in the same batches wherever a build stops, so that every bit is the same.
    most = min(BATCH, BATCH_PIXELS // config.size**2) if device is None else DEVICE_BATCH_PIXELS // config.size**2
    size = max(1, most)
    batches = [range(first, first + size) for first in range(done // size * size, config.count, size)]
    with (
        samples.open("a", encoding="utf-8") as lines,
        ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool,
        tqdm(total=config.count, initial=done, desc=f"{config.size} x {config.size}") as progress,
    ):
        wanted = [range(max(batch.start, done), min(batch.stop, config.count)) for batch in batches]
        for made in pool.map(_make_samples, repeat(directory), repeat(config), batches, wanted, repeat(device)):
            lines.writelines(json.dumps(asdict(sample)) + "\n" for sample in made)
            lines.flush()
            progress.update(len(made))


def read_samples(directory: Path) -> list[Sample]:
    """The samples of a data set, in order.

    Raises:
        DatasetError: there is no data set in the directory.
    """
    path = directory / "samples.jsonl"
    if not path.exists():
        raise DatasetError(f"{directory} holds no data set; build one with `asperity dataset`.")
    return [Sample(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]


def read_pairs(directory: Path) -> Iterator[tuple[ContactProblem, BoolArray]]:
    """Problems and reference contact masks of the samples that converged, in order."""
    for sample in read_samples(directory):
        if sample.status != Status.CONVERGED.name:
            continue
        codes = np.array(Image.open(directory / sample.heights), dtype=np.uint16)
        mask = np.array(Image.open(directory / sample.mask), dtype=np.bool_)
        problem = ContactProblem(
            heights=codes / CODES * (sample.height_range_um * 1e-6),
            pixel_size=(sample.pixel_size_y_um * 1e-6, sample.pixel_size_x_um * 1e-6),
            load=sample.load_n,
            effective_modulus=sample.effective_modulus_gpa * 1e9,
            boundary=sample.boundary,
        )
        yield problem, mask


def _claim(directory: Path, config: DatasetConfig) -> None:
    """Write the configuration, or check that the directory has the same one but for the count."""
    path = directory / "dataset.json"
    wanted = asdict(config)
    if path.exists():
        held = json.loads(path.read_text(encoding="utf-8"))
        differing = [key for key in wanted if key != "count" and held.get(key) != json.loads(json.dumps(wanted[key]))]
        if differing:
            raise DatasetError(
                f"{directory} holds a data set with another {', '.join(differing)}; choose another directory."
            )
    path.write_text(json.dumps(wanted, indent=2) + "\n", encoding="utf-8")


def _complete_lines(samples: Path) -> int:
    """Number of whole lines; a last line cut short by a stop is dropped."""
    if not samples.exists():
        return 0
    text = samples.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        samples.write_text(whole, encoding="utf-8")
    return whole.count("\n")


@dataclass(frozen=True)
class _Drawn:
    """A surface and its problem, before the solve."""

    name: str
    seed: int
    hurst: float
    codes: NDArray[np.uint16]
    problem: ContactProblem


def _make_samples(directory: Path, config: DatasetConfig, batch: range, wanted: range, device: Device) -> list[Sample]:
    """Draw and solve a batch, those of one boundary and pixel size side by side; store what is wanted of it, in order."""
    drawn = {index: _draw(config, index) for index in batch}
    kinds: dict[tuple[Boundary, tuple[float, float]], list[int]] = {}
    for index, one in drawn.items():
        kinds.setdefault((one.problem.boundary, one.problem.pixel_size), []).append(index)
    solved: dict[int, Solution] = {}
    for indices in kinds.values():
        problems = [drawn[index].problem for index in indices]
        solved |= zip(indices, solve_batch(problems, tolerance=config.tolerance, device=device), strict=True)
    return [_store(directory, config, drawn[index], solved[index]) for index in wanted]


def _draw(config: DatasetConfig, index: int) -> _Drawn:
    """The surface of a sample. Heights are quantised to 16 bits before the solve, as a user's would be."""
    seed = config.seed + index
    generator = np.random.default_rng([seed, 1])
    hurst = float(generator.uniform(*config.hurst_range))
    load = float(np.exp(generator.uniform(*np.log(config.load_range_n))))
    boundary: Boundary = "periodic" if generator.random() < config.periodic_share else "free"
    surface = random_midpoint_displacement(config.size, hurst, seed)
    dx_um = dy_um = config.side_mm * 1e3 / config.size
    instrument = generator.random() < config.instrument_share
    if instrument:
        surface = as_measured(surface, generator)
        dy_um *= pixel_aspect(generator)
    codes = np.rint(surface * CODES).astype(np.uint16)
    problem = ContactProblem(
        heights=codes / CODES * (config.height_range_um * 1e-6),
        pixel_size=(dy_um * 1e-6, dx_um * 1e-6),
        load=load,
        effective_modulus=config.effective_modulus_gpa * 1e9,
        boundary=boundary,
    )
    if instrument:
        relative = 10 ** generator.uniform(*LOG_LOAD_RANGE)
        load = relative * problem.effective_modulus * problem.nominal_area * problem.rms_slope
        problem = replace(problem, load=load)
    return _Drawn(f"{index:06d}", seed, hurst, codes, problem)


def _store(directory: Path, config: DatasetConfig, drawn: _Drawn, solution: Solution) -> Sample:
    """Write height map and mask of a sample."""
    problem, name = drawn.problem, drawn.name
    Image.fromarray(drawn.codes).save(directory / f"{name}.png", compress_level=COMPRESSION)
    Image.fromarray(solution.contact_mask).save(directory / f"{name}.mask.png", bits=1)
    return Sample(
        heights=f"{name}.png",
        mask=f"{name}.mask.png",
        seed=drawn.seed,
        hurst=drawn.hurst,
        load_n=problem.load,
        boundary=problem.boundary,
        pixel_size_x_um=problem.pixel_size[1] * 1e6,
        pixel_size_y_um=problem.pixel_size[0] * 1e6,
        height_range_um=config.height_range_um,
        effective_modulus_gpa=config.effective_modulus_gpa,
        tolerance=config.tolerance,
        status=solution.status.name,
        residual=solution.residual,
        contact_fraction=solution.contact_fraction,
    )
