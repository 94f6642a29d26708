"""The contact problem: what is given, validated once, in SI units."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from solver.errors import (
    InvalidHeightsError,
    InvalidLoadError,
    InvalidMaterialError,
    InvalidPixelSizeError,
    InvalidProblemError,
)

Boundary = Literal["free", "periodic"]
FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

SMALLEST_SIDE = 4
LARGEST_SIDE = 8192
MOST_ASPECT = 1000.0
LEAST_STRAIN, MOST_STRAIN = 1e-30, 1e12
"""Nominal pressure / E* beyond which floating-point numbers no longer hold the answer."""


def effective_modulus(
    youngs_modulus_1: float, poissons_ratio_1: float, youngs_modulus_2: float, poissons_ratio_2: float
) -> float:
    """Effective modulus E* of two elastic bodies, in Pa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.

    Raises:
        InvalidMaterialError: a Young's modulus that is not positive (infinity is allowed for one rigid body),
            or a Poisson's ratio outside (-1, 0.5].
    """
    for name, modulus in (("first", youngs_modulus_1), ("second", youngs_modulus_2)):
        if not modulus > 0:
            raise InvalidMaterialError(f"Young's modulus of the {name} body is {modulus:g} Pa; it must be positive.")
    for name, ratio in (("first", poissons_ratio_1), ("second", poissons_ratio_2)):
        if not -1 < ratio <= 0.5:
            raise InvalidMaterialError(f"Poisson's ratio of the {name} body is {ratio:g}; it must lie in (-1, 0.5].")
    compliance = (1 - poissons_ratio_1**2) / youngs_modulus_1 + (1 - poissons_ratio_2**2) / youngs_modulus_2
    if compliance == 0:
        raise InvalidMaterialError("Both bodies are rigid; at least one Young's modulus must be finite.")
    return 1 / compliance


@dataclass(frozen=True, eq=False)
class ContactProblem:
    """Frictionless elastic contact of a rough surface with a flat (paper Eqs. 1-6), validated on construction.

    Attributes:
        heights: surface heights in m, shape (rows, columns), high touches first; 4 to 8192 pixels a side.
        pixel_size: grid spacing along rows and columns (dy, dx), in m.
        load: total normal force on the nominal area, in N.
        effective_modulus: E* in Pa.
        boundary: ``free`` (an isolated patch on a half-space) or ``periodic``.
        hardness: highest pressure that the softer body bears, in Pa; where it is reached, the bodies may overlap, which
            stands for flow (elastic, perfectly plastic contact). None for elastic bodies.

    Raises:
        InvalidHeightsError, InvalidPixelSizeError, InvalidLoadError, InvalidMaterialError, InvalidProblemError:
            the message names the value and what is allowed.
    """

    heights: FloatArray
    pixel_size: tuple[float, float]
    load: float
    effective_modulus: float
    boundary: Boundary = "free"
    hardness: float | None = None

    def __post_init__(self) -> None:
        heights = _checked_heights(self.heights)
        heights.setflags(write=False)
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "pixel_size", _checked_pixel_size(self.pixel_size))
        if not np.isfinite(self.rms_height):
            raise InvalidHeightsError("The heights are too large for their rms to be a number; give them in metres.")
        if not (np.isfinite(self.load) and self.load > 0):
            raise InvalidLoadError(f"The load is {self.load:g} N; it must be a positive, finite force.")
        if not (np.isfinite(self.effective_modulus) and self.effective_modulus > 0):
            raise InvalidMaterialError(
                f"The effective modulus is {self.effective_modulus:g} Pa; it must be positive and finite."
            )
        strain = self.nominal_pressure / self.effective_modulus
        if not LEAST_STRAIN <= strain <= MOST_STRAIN:
            raise InvalidLoadError(
                f"The load of {self.load:g} N is {strain:g} times nominal area times effective modulus; that ratio must lie "
                f"between {LEAST_STRAIN:g} and {MOST_STRAIN:g}. Check the units of load, pixel size and moduli."
            )
        if self.boundary not in get_args(Boundary):
            raise InvalidProblemError(f"The boundary is {self.boundary!r}; it must be 'free' or 'periodic'.")
        if self.hardness is not None:
            self._check_hardness(self.hardness)

    def _check_hardness(self, hardness: float) -> None:
        if not (np.isfinite(hardness) and hardness > 0):
            raise InvalidMaterialError(f"The hardness is {hardness:g} Pa; it must be positive and finite.")
        if self.load >= hardness * self.nominal_area:
            raise InvalidLoadError(
                f"The load is {self.load:g} N; a surface of {self.nominal_area:g} m^2 with a hardness of {hardness:g} Pa "
                f"bears less than {hardness * self.nominal_area:g} N."
            )

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        rows, columns = self.heights.shape
        return rows, columns

    @property
    def pixel_area(self) -> float:
        """Area of one pixel, in m^2."""
        dy, dx = self.pixel_size
        return dy * dx

    @property
    def nominal_area(self) -> float:
        """Area of the whole map, in m^2."""
        return self.heights.size * self.pixel_area

    @property
    def nominal_pressure(self) -> float:
        """Load / nominal area, in Pa."""
        return self.load / self.nominal_area

    @cached_property
    def initial_gap(self) -> FloatArray:
        """Undeformed gap to a flat that touches the highest point, in m, shape (rows, columns)."""
        gap: FloatArray = self.heights.max() - self.heights
        return gap

    @cached_property
    def rms_height(self) -> float:
        """Root mean square of the heights about their mean, in m."""
        return float(self.initial_gap.std())

    @cached_property
    def rms_slope(self) -> float:
        """Root mean square of the surface gradient by forward differences, dimensionless."""
        dy, dx = self.pixel_size
        along_rows = np.diff(self.initial_gap, axis=0) / dy
        along_columns = np.diff(self.initial_gap, axis=1) / dx
        return float(np.sqrt(np.mean(along_rows**2) + np.mean(along_columns**2)))


def _checked_heights(heights: Any) -> FloatArray:
    values = np.array(heights, dtype=np.float64, order="C")
    if values.ndim != 2:
        raise InvalidHeightsError(f"Heights have shape {values.shape}; they must form a (rows, columns) array.")
    if not all(SMALLEST_SIDE <= side <= LARGEST_SIDE for side in values.shape):
        raise InvalidHeightsError(
            f"The height map has {values.shape[0]} x {values.shape[1]} pixels; "
            f"each side must have {SMALLEST_SIDE} to {LARGEST_SIDE}."
        )
    if not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values))[0]
        count = int((~np.isfinite(values)).sum())
        raise InvalidHeightsError(
            f"{count} of the heights are not finite (the first at row {row}, column {column}: {values[row, column]}); "
            "fill or crop missing pixels."
        )
    return values


def _checked_pixel_size(pixel_size: Any) -> tuple[float, float]:
    if np.shape(pixel_size) != (2,):
        raise InvalidPixelSizeError(f"The pixel size is {pixel_size!r}; it must be a pair (dy, dx) in metres.")
    dy, dx = float(pixel_size[0]), float(pixel_size[1])
    if not (np.isfinite(dy) and np.isfinite(dx) and dy > 0 and dx > 0):
        raise InvalidPixelSizeError(f"The pixel size is ({dy:g}, {dx:g}) m; both must be positive and finite.")
    if not (MOST_ASPECT >= dy / dx >= 1 / MOST_ASPECT and 0 < dy * dx < np.inf):
        raise InvalidPixelSizeError(
            f"The pixel size is ({dy:g}, {dx:g}) m; its sides may differ by a factor of {MOST_ASPECT:g} at most, and its "
            "area must be a positive number."
        )
    return dy, dx
