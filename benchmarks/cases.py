"""Contact problems of benchmarks and tests: on which solvers hang, crash, or claim what a fresh check denies, and others."""

from typing import Any

import numpy as np

from solver import ContactProblem, random_midpoint_displacement
from solver.problem import Boundary, FloatArray

SIZE = 64
PIXEL = 1e-3 / SIZE
ROUGH = random_midpoint_displacement(SIZE, seed=1) * 50e-6
ROWS, COLUMNS = np.mgrid[:SIZE, :SIZE]
NOISE = np.random.default_rng(2).standard_normal((SIZE, SIZE)) * 1e-6
USUAL: dict[str, Any] = {
    "heights": ROUGH,
    "pixel_size": (PIXEL, PIXEL),
    "load": 30.0,
    "effective_modulus": 6.843e9,
    "boundary": "free",
}


def spike(surface: np.ndarray) -> np.ndarray:
    """The surface with one pixel raised by 50 um above all."""
    raised = surface.copy()
    raised[20, 30] = surface.max() + 50e-6
    return raised


def with_nan() -> np.ndarray:
    """The usual surface with one pixel missing."""
    heights = ROUGH.copy()
    heights[10, 20] = np.nan
    return heights


SOLVABLE: dict[str, dict[str, Any]] = {
    "one pixel in contact": {"load": 1e-9},
    "a load lost in rounding": {"load": 1e-18},
    "seven pixels in contact": {"load": 0.5},
    "nearly full contact": {"load": 2.5e3},
    "full contact": {"load": 1e5},
    "one-pixel spike on a flat": {"heights": spike(np.zeros((SIZE, SIZE)))},
    "one-pixel spike on a rough surface": {"heights": spike(ROUGH)},
    "step of 50 um": {"heights": np.where(COLUMNS < SIZE // 2, 0.0, 50e-6)},
    "step of 50 um on a rough surface": {"heights": np.where(COLUMNS < SIZE // 2, 0.0, 50e-6) + ROUGH},
    "flat": {"heights": np.zeros((SIZE, SIZE))},
    "tilt": {"heights": COLUMNS * 1e-6},
    "slight tilt": {"heights": (COLUMNS + 0.3 * ROWS) * 1e-8},
    "checkerboard": {"heights": (COLUMNS + ROWS) % 2 * 1e-6},
    "white noise": {"heights": NOISE},
    "very smooth": {"heights": 1e-6 * np.cos(2 * np.pi * COLUMNS / SIZE) * np.cos(2 * np.pi * ROWS / SIZE), "load": 1.0},
    "heights times 1e-9": {"heights": ROUGH * 1e-9, "load": 30e-9},
    "heights times 1e+3": {"heights": ROUGH * 1e3},
    "E* of 1 kPa": {"effective_modulus": 1e3},
    "E* of 1 TPa": {"effective_modulus": 1e12},
    "pixels of 20:1": {"pixel_size": (20 * PIXEL, PIXEL)},
    "pixels of 1:20": {"pixel_size": (PIXEL, 20 * PIXEL)},
    "4 x 4": {"heights": NOISE[:4, :4], "load": 1e-2},
    "7 x 513": {"heights": np.random.default_rng(3).standard_normal((7, 513)) * 1e-6},
} | {f"load of 1e{exponent:+d} N": {"load": 10.0**exponent} for exponent in range(-6, 7, 2)}
"""What differs from the usual problem; each is solvable, on either boundary."""

REFUSED: dict[str, dict[str, Any]] = {
    "a NaN": {"heights": with_nan()},
    "no load": {"load": 0.0},
    "negative load": {"load": -30.0},
    "infinite load": {"load": np.inf},
}

HOPELESS: dict[str, tuple[dict[str, Any], float]] = {
    "gap lost in rounding": ({"heights": ROUGH * 1e-12, "load": 1e9, "effective_modulus": 1e9}, 1e-6),
    "tolerance of 1e-30": ({}, 1e-30),
}
"""Problems with tolerances that no double precision reaches."""


def midpoint_problem(size: int, load: float, boundary: Boundary = "free", seed: int = 1) -> ContactProblem:
    """A random midpoint surface of 1 mm square and 50 um high with the paper's material."""
    heights = random_midpoint_displacement(size, seed=seed) * 50e-6
    return ContactProblem(heights, (1e-3 / size, 1e-3 / size), load, 6.843e9, boundary)


def unlike_training() -> dict[str, FloatArray]:
    """Heights in m, shape (128, 128), of kinds that no surrogate is trained on."""
    generator = np.random.default_rng(0)
    y, x = np.mgrid[:128, :128]
    rough = random_midpoint_displacement(128, seed=40_000_000)
    noise, spikes = generator.standard_normal(rough.shape), generator.random(rough.shape) < 0.002
    return {
        "noise": 1e-7 * noise,
        "spikes": 1e-7 * (rough + 0.3 * spikes),
        "terraces": 1e-7 * np.round(40 * rough) / 40,
        "grating": 1e-7 * (np.sin(2.1 * x) + np.sin(1.7 * y) + 2 * rough),
        "checkerboard": 1e-7 * ((x // 3 + y // 3) % 2 + rough),
    }
