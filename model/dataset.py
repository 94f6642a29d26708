"""Data sets: height maps and the contact pressures that a solver found on them, in shards.

A directory holds ``dataset.json`` (the configuration), shards ``00000.safetensors``, ... and ``shards.jsonl`` with the hash
of each. A shard holds the tensors ``codes`` (height maps, uint16, shape (samples, rows, columns)) and ``pressure`` (float16,
in units of E* * rms slope, zero off contact, same shape), and in its metadata ``samples``, JSON, a list with what
:class:`Sample` names. The same configuration gives the same bits; a build that was stopped goes on with the next shard.
:func:`add_shard` takes samples from elsewhere, of any other solver.
"""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from safetensors import safe_open
from safetensors.numpy import save
from tqdm import tqdm

from model.errors import DatasetError
from model.families import CODES, Drawn, Family, Units, simple_problems, varied_problems
from solver.arrays import Device
from solver.problem import Boundary, ContactProblem, FloatArray
from solver.solution import Solution, Status
from solver.solve import solve_batch

BATCH, BATCH_PIXELS = 16, 2**18
"""Most surfaces, and pixels, that are solved side by side on the processor; more would not stay in its cache."""

DEVICE_BATCH_PIXELS = 2**24
"""Those on an accelerator, enough to keep it busy."""

SHARD, SHARD_PIXELS = 1024, 2**22
"""Most samples, and pixels, of a shard."""

LEAST_PRESSURE = float(np.finfo(np.float16).smallest_subnormal)


@dataclass(frozen=True)
class DatasetConfig:
    """What a data set contains; the defaults are the paper's test surfaces with the material of its figures.

    Attributes:
        size: pixels a side, a power of two.
        count: number of samples.
        seed: first surface seed; sample i has seed + i.
        family: of the surfaces, see :mod:`model.families`; the next two are not of varied ones.
        hurst_range: Hurst exponents are uniform in this range.
        load_range_n: loads are log-uniform in this range, in N.
        units: of the surfaces.
        tolerance: of the solver.
    """

    size: int = 128
    count: int = 100
    seed: int = 0
    family: Family = "midpoint"
    hurst_range: tuple[float, float] = (0.5, 0.5)
    load_range_n: tuple[float, float] = (10.0, 50.0)
    units: Units = field(default_factory=Units)
    tolerance: float = 1e-6

    @classmethod
    def restored(cls, values: dict[str, Any]) -> "DatasetConfig":
        """From what ``dataclasses.asdict`` and JSON made of one."""
        ranges = {name: tuple(values[name]) for name in ("hurst_range", "load_range_n")}
        return cls(**values | ranges | {"units": Units(**values["units"])})


Maker = Callable[[DatasetConfig, dict[int, range]], Iterator[tuple[int, bytes]]]


@dataclass(frozen=True)
class Sample:
    """What a shard says of one of its samples, besides the arrays.

    ``tolerance``, ``status`` and ``residual`` are of this package's solver. Where another solver knows the mask alone,
    ``pressure_known`` is false and the pressure is any number above zero in contact.
    """

    seed: int
    load_n: float
    boundary: Boundary
    pixel_size_x_um: float
    pixel_size_y_um: float
    height_range_um: float
    effective_modulus_gpa: float
    tolerance: float | None = None
    status: str = Status.CONVERGED.name
    residual: float | None = None
    pressure_known: bool = True

    def problem(self, codes: NDArray[np.uint16]) -> ContactProblem:
        """The contact problem with the heights of the codes."""
        return ContactProblem(
            heights=codes / CODES * (self.height_range_um * 1e-6),
            pixel_size=(self.pixel_size_y_um * 1e-6, self.pixel_size_x_um * 1e-6),
            load=self.load_n,
            effective_modulus=self.effective_modulus_gpa * 1e9,
            boundary=self.boundary,
        )


@dataclass(frozen=True, eq=False)
class Shard:
    """Samples with their arrays, shape (samples, rows, columns); see the module for units."""

    samples: list[Sample]
    codes: NDArray[np.uint16]
    pressure: NDArray[np.float16]


def build(directory: Path, config: DatasetConfig, processes: int = 1, device: Device = None) -> None:
    """Build a data set here, or the rest of one that was stopped.

    Args:
        directory: made if it is not there.
        config: what to build; a larger count than before extends the data set.
        processes: how many solve side by side.
        device: of torch, such as ``cuda``, to solve on; None for the processor. Its rounding differs from the processor's.

    Raises:
        DatasetError: the directory holds a data set of another configuration, or a larger one.
    """
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:

        def make(config: DatasetConfig, wanted: dict[int, range]) -> Iterator[tuple[int, bytes]]:
            return zip(wanted, pool.map(shard_bytes, repeat(config), wanted.values(), repeat(device)), strict=True)

        fill(directory, config, make)


def fill(directory: Path, config: DatasetConfig, make: Maker) -> None:
    """Build a data set, or the rest of one that was stopped, from shards that are made somewhere.

    Args:
        directory: made if it is not there.
        config: what to build; a larger count than before extends the data set.
        make: gives the shards whose samples it is told, by their numbers, in any order.

    Raises:
        DatasetError: the directory holds a data set of another configuration, or a larger one.
    """
    directory.mkdir(parents=True, exist_ok=True)
    _claim(directory, config)
    ledger = directory / "shards.jsonl"
    most = min(SHARD, SHARD_PIXELS // config.size**2)
    parts = [range(first, min(first + most, config.count)) for first in range(0, config.count, most)]
    done = [entry for entry in _entries(ledger) if entry["samples"] == len(parts[entry["shard"]])]
    wanted = {number: part for number, part in enumerate(parts) if number not in {entry["shard"] for entry in done}}
    _write_ledger(ledger, done)
    with tqdm(total=config.count, initial=sum(entry["samples"] for entry in done), desc=f"{directory}") as progress:
        for number, data in make(config, wanted):
            done.append(_store(directory, number, len(parts[number]), data))
            _write_ledger(ledger, sorted(done, key=lambda entry: int(entry["shard"])))
            progress.update(len(parts[number]))


def shard_paths(directory: Path) -> list[Path]:
    """The shards of a data set in order, their hashes checked.

    Raises:
        DatasetError: there is no data set in the directory, or a shard is not what was stored.
    """
    entries = _entries(directory / "shards.jsonl")
    if not entries:
        raise DatasetError(f"{directory} holds no data set; build one with `asperity dataset`.")
    paths = []
    for entry in sorted(entries, key=lambda entry: entry["shard"]):
        path = _path(directory, entry["shard"])
        if sha256(path.read_bytes()).hexdigest() != entry["sha256"]:
            raise DatasetError(f"{path} is not what was stored; build the data set again in another directory.")
        paths.append(path)
    return paths


def read_shard(path: Path) -> Shard:
    """A shard."""
    with safe_open(path, framework="np") as stored:
        samples = [Sample(**sample) for sample in json.loads(stored.metadata()["samples"])]
        return Shard(samples, stored.get_tensor("codes"), stored.get_tensor("pressure"))


def read_pairs(directory: Path) -> Iterator[tuple[ContactProblem, FloatArray]]:
    """Problems and reference pressures, in Pa, of the samples that converged, in order; contact is where they are not 0."""
    for path in shard_paths(directory):
        shard = read_shard(path)
        for sample, codes, pressure in zip(shard.samples, shard.codes, shard.pressure, strict=True):
            if sample.status == Status.CONVERGED.name:
                problem = sample.problem(codes)
                yield problem, pressure.astype(np.float64) * (problem.effective_modulus * problem.rms_slope)


def described(directory: Path) -> dict[str, Any]:
    """The configuration of a data set; only the count of one from elsewhere."""
    path = directory / "dataset.json"
    if path.exists():
        configuration: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return configuration
    return {"count": sum(entry["samples"] for entry in _entries(directory / "shards.jsonl"))}


def export(directory: Path) -> None:
    """Write each height map of a data set as PNG, 16 bits, with a line in ``samples.jsonl`` that names file and units."""
    number = 0
    with (directory / "samples.jsonl").open("w", encoding="utf-8") as lines:
        for path in shard_paths(directory):
            shard = read_shard(path)
            for sample, codes in zip(shard.samples, shard.codes, strict=True):
                name = f"{number:06d}.png"
                Image.fromarray(codes).save(directory / name)
                lines.write(json.dumps({"heights": name} | asdict(sample)) + "\n")
                number += 1


def _claim(directory: Path, config: DatasetConfig) -> None:
    """Write the configuration, or check that the directory has the same one but for the count."""
    path = directory / "dataset.json"
    wanted = json.loads(json.dumps(asdict(config)))
    if path.exists():
        held = json.loads(path.read_text(encoding="utf-8"))
        differing = [key for key in wanted if key != "count" and held.get(key) != wanted[key]]
        if differing:
            raise DatasetError(
                f"{directory} holds a data set with another {', '.join(differing)}; choose another directory."
            )
        if held["count"] > config.count:
            raise DatasetError(f"{directory} holds a data set of {held['count']} samples; choose another directory.")
    path.write_text(json.dumps(wanted, indent=2) + "\n", encoding="utf-8")


def _entries(ledger: Path) -> list[dict[str, Any]]:
    """The lines of a ledger."""
    text = ledger.read_text(encoding="utf-8") if ledger.exists() else ""
    return [json.loads(line) for line in text.splitlines()]


def _write_ledger(ledger: Path, entries: list[dict[str, Any]]) -> None:
    """Write a ledger so that a stop in the middle leaves the last one whole."""
    temporary = ledger.with_suffix(".tmp")
    temporary.write_text("".join(json.dumps(entry) + "\n" for entry in entries), encoding="utf-8")
    temporary.replace(ledger)


def _path(directory: Path, number: int) -> Path:
    return directory / f"{number:05d}.safetensors"


def shard_bytes(config: DatasetConfig, indices: range, device: Device = None) -> bytes:
    """Draw and solve some samples: a shard as its file holds it. What is drawn does not depend on the device."""
    most = max(1, min(BATCH, BATCH_PIXELS // config.size**2))
    firsts = range(indices.start, indices.stop, most)
    draws = [draw(config, range(first, min(first + most, indices.stop))) for first in firsts]
    batches = draws if device is None else _gathered(draws, max(1, DEVICE_BATCH_PIXELS // config.size**2))
    solved: dict[int, Solution] = {}
    for batch in batches:
        solutions = solve_batch([one.problem for one in batch], tolerance=config.tolerance, device=device)
        solved |= {one.seed: solution for one, solution in zip(batch, solutions, strict=True)}
    samples, codes, pressures = [], [], []
    for one in (one for batch in draws for one in batch):
        solution = solved[one.seed]
        samples.append(_sample(config, one, solution))
        codes.append(one.codes)
        pressures.append(scaled_pressure(one.problem, solution.pressure))
    return _packed(Shard(samples, np.stack(codes), np.stack(pressures)))


def scaled_pressure(problem: ContactProblem, pressure: FloatArray) -> NDArray[np.float16]:
    """A pressure in Pa as shards hold it: in units of E* rms slope, above zero wherever it was."""
    scaled = pressure / (problem.effective_modulus * problem.rms_slope)
    return np.where(pressure > 0, np.maximum(scaled, LEAST_PRESSURE), 0).astype(np.float16)


def _gathered(draws: list[list[Drawn]], most: int) -> list[list[Drawn]]:
    """Larger batches, each of one boundary and pixel size."""
    kinds: dict[tuple[Boundary, tuple[float, float]], list[Drawn]] = {}
    for batch in draws:
        kinds.setdefault((batch[0].problem.boundary, batch[0].problem.pixel_size), []).extend(batch)
    return [kind[first : first + most] for kind in kinds.values() for first in range(0, len(kind), most)]


def _packed(shard: Shard) -> bytes:
    metadata = {"samples": json.dumps([asdict(sample) for sample in shard.samples])}
    return save({"codes": shard.codes, "pressure": shard.pressure}, metadata)


def _store(directory: Path, number: int, samples: int, data: bytes) -> dict[str, Any]:
    """Write a shard; returns its line in the ledger."""
    path = _path(directory, number)
    temporary = path.with_suffix(".tmp")
    temporary.write_bytes(data)
    temporary.replace(path)
    return {"shard": number, "samples": samples, "sha256": sha256(data).hexdigest()}


def add_shard(directory: Path, shard: Shard) -> None:
    """Add samples from elsewhere, of any other solver, to a data set of one's own.

    Args:
        directory: made if it is not there; not one that :func:`build` fills.
        shard: samples of one shape.

    Raises:
        DatasetError: arrays that do not go together, or a map without contact.
    """
    shapes = {shard.codes.shape, shard.pressure.shape, (len(shard.samples), *shard.codes.shape[1:])}
    if len(shapes) > 1 or shard.codes.dtype != np.uint16 or shard.pressure.dtype != np.float16:
        raise DatasetError(
            f"There are {len(shard.samples)} samples, {shard.codes.dtype} codes of shape {shard.codes.shape} and "
            f"{shard.pressure.dtype} pressures of shape {shard.pressure.shape}; give uint16 codes and float16 pressures of "
            "shape (samples, rows, columns)."
        )
    if not (shard.pressure > 0).any(axis=(1, 2)).all():
        raise DatasetError("A map has no contact; every load touches somewhere.")
    directory.mkdir(parents=True, exist_ok=True)
    ledger = directory / "shards.jsonl"
    done = _entries(ledger)
    _write_ledger(ledger, [*done, _store(directory, len(done), len(shard.samples), _packed(shard))])


def draw(config: DatasetConfig, indices: range) -> list[Drawn]:
    """The problems of some samples; they share grid, boundary and pixel size."""
    seeds = range(config.seed + indices.start, config.seed + indices.stop)
    if config.family == "varied":
        return varied_problems(config.size, seeds, config.units)
    return simple_problems(config.family, config.size, seeds, config.hurst_range, config.load_range_n, config.units)


def _sample(config: DatasetConfig, drawn: Drawn, solution: Solution) -> Sample:
    problem = drawn.problem
    return Sample(
        seed=drawn.seed,
        load_n=problem.load,
        boundary=problem.boundary,
        pixel_size_x_um=problem.pixel_size[1] * 1e6,
        pixel_size_y_um=problem.pixel_size[0] * 1e6,
        height_range_um=config.units.height_range_um,
        effective_modulus_gpa=config.units.effective_modulus_gpa,
        tolerance=config.tolerance,
        status=solution.status.name,
        residual=solution.residual,
    )
