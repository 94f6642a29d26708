"""Which operator evaluates the displacement where: exactly for all pixels, or fast for the candidates."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

from threadpoolctl import threadpool_limits

from solver.arrays import Device
from solver.convolution import Convolution, Precision, convolution
from solver.multilevel import Multilevel
from solver.problem import BoolArray, Boundary

Method = Literal["fft", "multilevel"]

ACTIVE_SHARE = 0.18
"""Sums over tiles beat transforms of 128 * 2^k pixels a side up to k times this share of tiles with candidates."""

FEWEST_PIXELS = 128**2

CERTIFICATE = {"order": 8, "tile": 14}
ITERATION = {"order": 4, "tile": 6}
"""Transfer and tiles of the multilevel operator; the check corrects what the iteration leaves."""

MOST_PIXELS_A_SIDE = 4096
"""For which operators are prepared; larger ones have a coarser level more."""

ERROR = {"fft": 1e-15, "multilevel": 3e-10}
"""Largest errors of the displacement in the check, relative to the largest displacement, over all shapes and aspects."""


@lru_cache(maxsize=8)
def multilevel(
    shape: tuple[int, int], pixel_size: tuple[float, float], precision: Precision, order: int, tile: int
) -> Multilevel:
    """The multilevel operator for a grid; the few last used are kept."""
    return Multilevel(shape, pixel_size, precision, order, tile)


def prepare_multilevel() -> None:
    """Build what the multilevel operators of square pixels share, half a second's work, for this process and its forks."""
    with threadpool_limits(1):  # a process that is to be forked starts no threads
        multilevel((MOST_PIXELS_A_SIDE,) * 2, (1.0, 1.0), "float64", **CERTIFICATE)
        multilevel((MOST_PIXELS_A_SIDE,) * 2, (1.0, 1.0), "float32", **ITERATION)


@dataclass(frozen=True)
class Operators:
    """The displacement on one grid.

    Attributes:
        method: how it is evaluated for all pixels.
        boundary: of the surfaces.
        shape: (rows, columns).
        pixel_size: (dy, dx) in any unit; only the aspect matters.
        device: where the arrays are.
    """

    method: Method
    boundary: Boundary
    shape: tuple[int, int]
    pixel_size: tuple[float, float]
    device: Device

    def exact(self) -> Convolution:
        """The operator of the certificate, in double precision."""
        if self.method == "multilevel":
            return multilevel(self.shape, self.pixel_size, "float64", **CERTIFICATE)
        return convolution(self.boundary, self.shape, self.pixel_size, "float64", self.device)

    @property
    def error(self) -> float:
        """Of the exact operator, relative to the largest displacement."""
        return ERROR[self.method]

    def inner(self, mask: BoolArray) -> Convolution:
        """The fastest operator for the iteration on the pixels of a mask, (surfaces, rows, columns); in single precision."""
        if self.method == "multilevel" or (
            self.boundary == "free"
            and self.device is None
            and mask[0].size > FEWEST_PIXELS
            and _active_share(mask) <= ACTIVE_SHARE * math.log2(math.sqrt(mask[0].size) / 128)
        ):
            return multilevel(self.shape, self.pixel_size, "float32", **ITERATION)
        return convolution(self.boundary, self.shape, self.pixel_size, "float32", self.device)

    def coarser(self) -> "Operators":
        """Those of the grid with pixels twice as large."""
        rows, columns = self.shape
        return replace(self, shape=(-(-rows // 2), -(-columns // 2)))


def _active_share(mask: BoolArray) -> float:
    """Share of the tiles that hold any pixel of a mask."""
    _, rows, columns = mask.shape
    tile = ITERATION["tile"]
    whole = mask[:, : rows - rows % tile, : columns - columns % tile]
    tiles = whole.reshape(len(mask), rows // tile, tile, columns // tile, tile)
    return float(tiles.any(axis=(2, 4)).mean())
