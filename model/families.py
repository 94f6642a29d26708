"""Contact problems to train and test on: the paper's surfaces, and a variety of all that a user may bring.

Problems of one draw share grid, boundary and pixel size, so that they can be solved side by side.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from model.instrument import as_measured, pixel_aspect
from solver.midpoint import random_midpoint_displacement
from solver.problem import Boundary, ContactProblem, FloatArray
from solver.spectral import spectral_surface

Family = Literal["midpoint", "roll-off", "anisotropic", "skewed", "varied"]
"""``midpoint`` are the paper's surfaces; the next three are spectral ones, all on the free boundary. ``varied`` is
everything, on both boundaries."""

CODES = 65535
"""Highest code of a height map of 16 bits; code 0 is the lowest height, CODES the highest."""

HURST_RANGE = (0.2, 0.9)
LOG_LOAD_RANGE = (-4.0, -0.45)
"""log10 F / (E* A0 * rms slope), uniform: from first touch to two fifths of the map, so that small contact is not rare."""

PERIODIC_SHARE = 0.25
MIDPOINT_SHARE = 0.4
"""Of the varied surfaces; the others are made by spectral synthesis."""

INSTRUMENT_SHARE = 0.2
"""Share of the varied surfaces with the form, lay and noise of measured maps."""


@dataclass(frozen=True)
class Units:
    """What gives a dimensionless surface its units.

    Attributes:
        side_mm: length of a row.
        height_range_um: lowest to highest height.
        effective_modulus_gpa: E*.
    """

    side_mm: float = 1.0
    height_range_um: float = 50.0
    effective_modulus_gpa: float = 6.843


@dataclass(frozen=True, eq=False)
class Drawn:
    """A surface and its problem.

    Attributes:
        seed: of the surface.
        codes: heights as a file of 16 bits holds them.
        problem: with the heights of the codes.
    """

    seed: int
    codes: NDArray[np.uint16]
    problem: ContactProblem


def simple_problems(
    family: Family,
    size: int,
    seeds: range,
    hurst_range: tuple[float, float],
    load_range_n: tuple[float, float],
    units: Units,
) -> list[Drawn]:
    """Surfaces of one kind, with Hurst exponents uniform and loads log-uniform in their ranges."""
    drawn = []
    for seed in seeds:
        generator = np.random.default_rng([seed, 1])
        hurst = float(generator.uniform(*hurst_range))
        load = float(np.exp(generator.uniform(*np.log(load_range_n))))
        midpoint = family == "midpoint"
        surface = random_midpoint_displacement(size, hurst, seed) if midpoint else _spectral(family, size, hurst, seed)
        drawn.append(_problem(seed, surface, units, "free", 1.0, load))
    return drawn


def _spectral(family: Family, size: int, hurst: float, seed: int) -> FloatArray:
    """Heights from 0 to 1, shape (size, size): an eighth of the map long, five times as long as wide, or worn plateaus."""
    surface = spectral_surface(
        (size, size),
        (1.0, 1.0),
        rms_height=1.0,
        hurst=hurst,
        rolloff_wavelength=size / 8 if family == "roll-off" else None,
        anisotropy=5.0 if family == "anisotropic" else 1.0,
        skewness=-1.5 if family == "skewed" else 0.0,
        seed=seed,
    )
    return _normalised(surface)


def varied_problems(size: int, seeds: range, units: Units) -> list[Drawn]:
    """Surfaces of many kinds under loads from first touch on; boundary and pixel size are drawn once for all seeds."""
    shared = np.random.default_rng([seeds.start, 2])
    boundary: Boundary = "periodic" if shared.random() < PERIODIC_SHARE else "free"
    aspect = pixel_aspect(shared)
    drawn = []
    for seed in seeds:
        generator = np.random.default_rng([seed, 1])
        surface = _varied_surface(size, seed, aspect, generator)
        one = _problem(seed, surface, units, boundary, aspect, 1.0)
        scale = one.problem.effective_modulus * one.problem.nominal_area * one.problem.rms_slope
        load = scale * 10 ** generator.uniform(*LOG_LOAD_RANGE)
        drawn.append(_problem(seed, surface, units, boundary, aspect, load))
    return drawn


def _varied_surface(size: int, seed: int, aspect: float, generator: np.random.Generator) -> FloatArray:
    """Heights from 0 to 1, shape (size, size)."""
    hurst = float(generator.uniform(*HURST_RANGE))
    if generator.random() < MIDPOINT_SHARE:
        surface = random_midpoint_displacement(size, hurst, seed)
    else:
        surface = spectral_surface(
            (size, size),
            (aspect, 1.0),
            rms_height=1.0,
            hurst=hurst,
            rolloff_wavelength=size / _log_uniform(generator, 1, 16) if generator.random() < 0.6 else None,
            shortest_wavelength=_log_uniform(generator, 2, 16) * max(aspect, 1) if generator.random() < 0.3 else None,
            anisotropy=_log_uniform(generator, 0.1, 10) if generator.random() < 0.3 else 1.0,
            skewness=generator.uniform(-2, 1.5) if generator.random() < 0.15 else 0.0,
            seed=seed,
        )
    if generator.random() < INSTRUMENT_SHARE:
        surface = as_measured(surface, generator)
    return _normalised(surface)


def _normalised(surface: FloatArray) -> FloatArray:
    """From 0 to 1."""
    result: FloatArray = (surface - surface.min()) / np.ptp(surface)
    return result


def _problem(seed: int, surface: FloatArray, units: Units, boundary: Boundary, aspect: float, load: float) -> Drawn:
    """The problem of a surface from 0 to 1. Heights are rounded to 16 bits before the solve, as a user's would be."""
    codes = np.rint(surface * CODES).astype(np.uint16)
    dx = units.side_mm * 1e-3 / surface.shape[1]
    problem = ContactProblem(
        heights=codes / CODES * (units.height_range_um * 1e-6),
        pixel_size=(aspect * dx, dx),
        load=load,
        effective_modulus=units.effective_modulus_gpa * 1e9,
        boundary=boundary,
    )
    return Drawn(seed, codes, problem)


def _log_uniform(generator: np.random.Generator, lowest: float, highest: float) -> float:
    return float(np.exp(generator.uniform(np.log(lowest), np.log(highest))))
