"""What the network sees: dimensionless fields of a contact problem and of its solution on a four times coarser grid.

One network serves every material, load, size and grid, because nothing here has a unit: gaps are in units of
s * rms slope (s = sqrt(dx dy)), pressures in units of E* * rms slope.
"""

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from solver.coarsening import coarsened
from solver.problem import ContactProblem, FloatArray
from solver.solve import solve

COARSENING = 4
"""Ratio of the coarse solve's pixel side to that of the map."""

SMALLEST_SIDE = 4 * COARSENING
"""Pixels a side below which the coarse grid has too few."""

COARSE_TOLERANCE = 1e-3
GAP_CLIP = 3.0
CHANNELS = 4
LOAD_CHANNEL = 3


def features(problem: ContactProblem) -> Tensor:
    """Input of the network.

    The displacement of the coarse solution is smooth, so it is interpolated to the fine grid, where the fine heights turn
    it into a first guess of the gap; the network corrects it, so the coarse solve need not have converged. Needs at least
    ``SMALLEST_SIDE`` pixels a side and heights that are not constant.

    Returns:
        float32 tensor of shape (CHANNELS, rows, columns): the guessed gap clipped to +-GAP_CLIP, its asinh, the coarse
        pressure interpolated, and log10 F / (E* A0 * rms slope) as a constant.
    """
    coarse = coarsened(problem, COARSENING)
    solution = solve(coarse, tolerance=COARSE_TOLERANCE)
    flat = _refine(solution.gap + coarse.heights, problem.shape)
    slope = problem.rms_slope
    gap = torch.from_numpy((flat - problem.heights) / (np.sqrt(problem.pixel_area) * slope))
    pressure = torch.from_numpy(_refine(solution.pressure, problem.shape) / (problem.effective_modulus * slope))
    load = np.log10(problem.nominal_pressure / (problem.effective_modulus * slope))
    channels = [gap.clamp(-GAP_CLIP, GAP_CLIP), gap.asinh(), pressure, torch.full_like(gap, load)]
    return torch.stack(channels).to(torch.float32)


def _refine(field: FloatArray, shape: tuple[int, int]) -> FloatArray:
    """Bicubic interpolation from the coarse to the fine pixel centres, shape (rows, columns)."""
    fine = functional.interpolate(
        torch.from_numpy(field)[None, None], scale_factor=COARSENING, mode="bicubic", align_corners=False
    )
    refined: FloatArray = fine[0, 0, : shape[0], : shape[1]].numpy()
    return refined
