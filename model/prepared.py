"""Data sets made ready for training: the features of every sample, kept beside the shards and then in memory."""

from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors.torch import load_file, save_file
from torch import Tensor
from tqdm import tqdm

from model.dataset import Shard, read_shard, shard_paths
from model.families import CODES
from model.features import Features, features
from solver.solution import Status

BATCH = 16
"""Samples whose coarse problems are solved side by side; those of a data set made here share boundary and pixel size."""

HELD_OUT = {"validation": 0, "test": 1}
"""A tenth of the surface seeds each: their last digit."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """Samples of one grid.

    Attributes:
        seeds: of the surfaces, shape (samples,).
        codes: height maps, uint16, shape (samples, rows, columns).
        pressure: reference, float16, same shape, in units of E* * rms slope.
        known: whether the pressure is more than a mask, shape (samples,).
        mean, scale: heights in units of s * rms slope are (codes - mean) * scale; shape (samples,).
        coarse, conditions: see :class:`model.features.Features`.
    """

    seeds: Tensor
    codes: Tensor
    pressure: Tensor
    known: Tensor
    mean: Tensor
    scale: Tensor
    coarse: Tensor
    conditions: Tensor

    def __len__(self) -> int:
        return len(self.codes)

    def features(self, samples: Tensor) -> Features:
        """Features of some samples."""
        mean, scale = (field[samples][:, None, None] for field in (self.mean, self.scale))
        return Features((self.codes[samples].float() - mean) * scale, self.coarse[samples], self.conditions[samples])

    def members(self, part: str) -> Tensor:
        """Numbers of the samples of ``training``, ``validation`` or ``test``, split by surface seed."""
        digit = self.seeds % 10
        if part == "training":
            return torch.nonzero(~torch.isin(digit, torch.tensor(list(HELD_OUT.values()))))[:, 0]
        return torch.nonzero(digit == HELD_OUT[part])[:, 0]


def prepare(directories: Iterable[Path], processes: int) -> list[Prepared]:
    """The samples of data sets that converged, by grid; features that were not computed before are now.

    Raises:
        DatasetError: there is no data set in a directory, or a shard is not what was stored.
    """
    shards = [path for directory in directories for path in shard_paths(directory)]
    missing = [path for path in shards if not _beside(path).exists()]
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        for _ in tqdm(pool.map(_prepare, missing), total=len(missing), desc="features", unit="shard", disable=not missing):
            pass
    grids: dict[tuple[int, ...], list[dict[str, Tensor]]] = {}
    for path in tqdm(shards, desc="data", unit="shard"):
        arrays = _read(path)
        grids.setdefault(tuple(arrays["codes"].shape[1:]), []).append(arrays)
    return [Prepared(**{name: torch.cat([part[name] for part in parts]) for name in parts[0]}) for parts in grids.values()]


def _read(path: Path) -> dict[str, Tensor]:
    shard = read_shard(path)
    kept = torch.tensor([sample.status == Status.CONVERGED.name for sample in shard.samples])
    arrays = load_file(_beside(path)) | {
        "seeds": torch.tensor([sample.seed for sample in shard.samples]),
        "codes": torch.from_numpy(shard.codes),
        "pressure": torch.from_numpy(shard.pressure),
        "known": torch.tensor([sample.pressure_known for sample in shard.samples]),
    }
    return {name: array[kept] for name, array in arrays.items()}


def _beside(path: Path) -> Path:
    return path.with_suffix(".features")


def _prepare(path: Path) -> None:
    shard = read_shard(path)
    parts = [_arrays(shard, first) for first in range(0, len(shard.samples), BATCH)]
    arrays = {name: torch.cat([part[name] for part in parts]) for name in parts[0]}
    temporary = path.with_suffix(".tmp")
    save_file(arrays, temporary)
    temporary.replace(_beside(path))


def _arrays(shard: Shard, first: int) -> dict[str, Tensor]:
    """Features of a batch, heights left out."""
    numbers = range(first, min(first + BATCH, len(shard.samples)))
    problems = [shard.samples[i].problem(shard.codes[i]) for i in numbers]
    made: dict[tuple[Any, ...], list[int]] = {}
    for place, problem in enumerate(problems):
        made.setdefault((problem.boundary, problem.pixel_size), []).append(place)
    places = [place for group in made.values() for place in group]
    groups = [features([problems[place] for place in group]) for group in made.values()]
    order = torch.argsort(torch.tensor(places))
    units = [np.sqrt(problem.pixel_area) * problem.rms_slope for problem in problems]
    steps = [shard.samples[i].height_range_um * 1e-6 / CODES for i in numbers]
    return {
        "mean": torch.tensor([float(shard.codes[i].mean()) for i in numbers]),
        "scale": torch.tensor([step / unit for step, unit in zip(steps, units, strict=True)]).float(),
        "coarse": torch.cat([group.coarse for group in groups])[order],
        "conditions": torch.cat([group.conditions for group in groups])[order],
    }
