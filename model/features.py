"""What the network sees: dimensionless fields of a contact problem and of its solution on a four times coarser grid.

One network serves every material, load, size and grid, because nothing here has a unit: gaps are in units of
s * rms slope (s = sqrt(dx dy)), pressures in units of E* * rms slope.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from solver.coarsening import coarsened
from solver.problem import ContactProblem, FloatArray
from solver.solve import solve_batch

COARSENING = 4
"""Ratio of the coarse solve's pixel side to that of the map."""

SMALLEST_SIDE = 4 * COARSENING
"""Pixels a side below which the coarse grid has too few."""

COARSE_TOLERANCE = 3e-3
GAP_CLIP = 3.0
CHANNELS = 4
CONDITIONS = 2
TYPICAL_LOG_LOAD = -2.0
"""About which the logarithm of the dimensionless load is centred."""


@dataclass(frozen=True, eq=False)
class Features:
    """Dimensionless fields of problems of one shape, from which the input of the network is made.

    Attributes:
        heights: in units of s * rms slope, float32, shape (problems, rows, columns).
        coarse: the deformed flat, in the same units, and the pressure of the coarse solution, float32, shape (problems, 2,
            coarse rows, coarse columns).
        conditions: log10 F / (E* A0 * rms slope), centred, and ln dy / dx; float32, shape (problems, CONDITIONS).
    """

    heights: Tensor
    coarse: Tensor
    conditions: Tensor

    @property
    def load(self) -> Tensor:
        """Mean pressure in units of E* * rms slope, shape (problems,)."""
        result: Tensor = 10 ** (self.conditions[:, 0] + TYPICAL_LOG_LOAD)
        return result

    def split(self, most: int) -> Iterator["Features"]:
        """Parts of so many problems at most."""
        for parts in zip(self.heights.split(most), self.coarse.split(most), self.conditions.split(most), strict=True):
            yield Features(*parts)


def features(problems: Sequence[ContactProblem]) -> Features:
    """Features of problems of one shape, pixel size and boundary.

    The displacement of the coarse solution is smooth, so it is interpolated to the fine grid, where the fine heights turn
    it into a first guess of the gap; the network corrects it, so the coarse solve need not have converged. Needs at least
    ``SMALLEST_SIDE`` pixels a side and heights that are not constant.
    """
    coarse = [coarsened(problem, COARSENING) for problem in problems]
    heights, fields, conditions = [], [], []
    for problem, small, solution in zip(problems, coarse, solve_batch(coarse, tolerance=COARSE_TOLERANCE), strict=True):
        slope, mean = problem.rms_slope, problem.heights.mean()
        unit = np.sqrt(problem.pixel_area) * slope
        flat = solution.gap + small.heights - mean
        heights.append(((problem.heights - mean) / unit).astype(np.float32))
        fields.append(np.stack([flat / unit, solution.pressure / (problem.effective_modulus * slope)]).astype(np.float32))
        conditions.append(_conditions(problem).astype(np.float32))
    return Features(*(torch.from_numpy(np.stack(values)) for values in (heights, fields, conditions)))


def log_load(problem: ContactProblem) -> float:
    """log10 F / (E* A0 * rms slope)."""
    return float(np.log10(problem.nominal_pressure / (problem.effective_modulus * problem.rms_slope)))


def _conditions(problem: ContactProblem) -> FloatArray:
    dy, dx = problem.pixel_size
    return np.array([log_load(problem) - TYPICAL_LOG_LOAD, np.log(dy / dx)])


def network_input(given: Features) -> Tensor:
    """Input of the network.

    Returns:
        float32, shape (problems, CHANNELS, rows, columns): the guessed gap, clipped to +-GAP_CLIP, and squashed where it is
        large; the coarse pressure interpolated, and its root.
    """
    rows, columns = given.heights.shape[-2:]
    fine = functional.interpolate(given.coarse, scale_factor=COARSENING, mode="bicubic", align_corners=False)
    flat, pressure = fine[:, 0, :rows, :columns], fine[:, 1, :rows, :columns].clamp_min(0)
    gap = flat - given.heights
    channels = [gap.clamp(-GAP_CLIP, GAP_CLIP), functional.softsign(gap / GAP_CLIP), pressure, pressure.sqrt()]
    return torch.stack(channels, dim=1)


def coarse_heights(heights: Tensor) -> Tensor:
    """Heights as the coarse grid sees them, interpolated back, shape (problems, rows, columns)."""
    rows, columns = heights.shape[-2:]
    means = functional.avg_pool2d(heights[:, None], COARSENING, ceil_mode=True, count_include_pad=False)
    fine = functional.interpolate(means, scale_factor=COARSENING, mode="bicubic", align_corners=False)
    return fine[:, 0, :rows, :columns]
