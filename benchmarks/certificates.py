"""A judge of pressures that shares nothing with the solver: SciPy's convolution, Love's coefficients as he wrote them."""

from itertools import product

import numpy as np
from scipy.signal import fftconvolve

from solver import ContactProblem


def love(pixel_size: tuple[float, float], shape: tuple[int, int]) -> np.ndarray:
    """Love's influence coefficients for distances from -rows + 1 to rows - 1, in m/Pa times E* (Johnson, Eq. 3.25)."""
    (dy, dx), (rows, columns) = pixel_size, shape
    y, x = np.meshgrid(np.arange(1 - rows, rows) * dy, np.arange(1 - columns, columns) * dx, indexing="ij")
    total = np.zeros_like(x)
    for sign_y, sign_x in product((1, -1), (1, -1)):
        v, u = y + sign_y * dy / 2, x + sign_x * dx / 2
        total += sign_y * sign_x * (u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v)))
    return total / np.pi


def displacement(problem: ContactProblem, pressure: np.ndarray) -> np.ndarray:
    """Displacement in m under a pressure in Pa."""
    rows, columns = problem.shape
    if problem.boundary == "free":
        full = fftconvolve(pressure, love(problem.pixel_size, problem.shape))
        return full[rows - 1 : 2 * rows - 1, columns - 1 : 2 * columns - 1] / problem.effective_modulus
    dy, dx = problem.pixel_size
    q = 2 * np.pi * np.hypot(*np.meshgrid(np.fft.fftfreq(rows, dy), np.fft.fftfreq(columns, dx), indexing="ij"))
    q[0, 0] = np.inf
    return np.fft.ifft2(np.fft.fft2(pressure) * 2 / q).real / problem.effective_modulus


def violation(problem: ContactProblem, pressure: np.ndarray) -> float:
    """Largest of sum p |g| / (F height scale), deepest penetration / height scale, load imbalance; inf for no pressure."""
    if not np.isfinite(pressure).all() or pressure.min() < -1e-9 * np.abs(pressure).max() or pressure.max() <= 0:
        return float("inf")
    pressure = np.maximum(pressure, 0)
    separation = displacement(problem, pressure) + problem.initial_gap
    gap = separation - np.average(separation, weights=pressure)
    scale = problem.rms_height or problem.load / (problem.effective_modulus * np.sqrt(problem.nominal_area))
    complementarity = float((pressure * np.abs(gap)).sum() / pressure.sum() / scale)
    imbalance = abs(float(pressure.sum()) * problem.pixel_area / problem.load - 1)
    return max(complementarity, -float(gap.min()) / scale, imbalance)
