"""Displacement by pressure: multilevel multi-summation (paper Eqs. 7-9), without Fourier transforms.

The grid is cut into square tiles. Between pixels of touching tiles influence is summed exactly; between all others the
kernel is smooth, so the pressure is restricted to a grid with pixels twice as large, summed there, in the same way, and the
displacement interpolated back. What the coarse sum says of touching tiles is part of the stencil that corrects it. All
of it is matrix products on tiles, linear in the number of pixels, and tiles without pressure, or whose displacement nobody
asks for, cost nothing.

Largest error relative to the largest displacement, for pressures of contact on 256 x 256 pixels, and products a pixel:

=====  ====  =======  ========
order  tile  error    products
=====  ====  =======  ========
4      6     1.5e-6   650
4      8     7e-7     1150
6      8     5e-8     1150
6      12    2e-9     2600
8      12    2e-10    2600
8      14    5e-11    3500
=====  ====  =======  ========

Source: Brandt & Lubrecht 1990, doi:10.1016/0021-9991(90)90171-V; Polonsky & Keer 1999, doi:10.1016/S0043-1648(99)00113-1.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.arrays import Device
from solver.hierarchy import Pair, hierarchy
from solver.problem import IntArray
from solver.routes import Route, numbered, routes
from solver.threads import side_by_side

CHUNK = 512
"""Tiles summed at a time, few enough to stay in the cache."""


class Multilevel:
    """Multilevel multi-summation on an isolated patch, for one surface or a batch of them.

    Args:
        shape: (rows, columns) of the grid.
        pixel_size: (dy, dx) in any unit; only the aspect matters.
        precision: of the sums.
        order: of the transfer, even.
        tile: pixels a side of a tile, even, with at least ``order`` / 2 coarse pixels under it.
    """

    def __init__(
        self, shape: Pair, pixel_size: tuple[float, float], precision: str = "float64", order: int = 6, tile: int = 8
    ) -> None:
        self.dtype = np.dtype(precision)
        self.device: Device = None
        self.shape = shape
        self.tile = tile
        self._levels, self._bottom = hierarchy(shape, pixel_size[0] / pixel_size[1], precision, order, tile)

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Displacement in units of s, s = sqrt(dx dy), for a pressure in units of E*, shape (..., rows, columns)."""
        batch = pressure.reshape(-1, *self.shape)
        rows, columns = self.shape
        high, wide = self._grid
        padded = np.zeros((len(batch), high * self.tile, wide * self.tile), self.dtype)
        padded[:, :rows, :columns] = batch
        tiles = padded.reshape(len(batch), high, self.tile, wide, self.tile).swapaxes(2, 3)
        sources = np.ones(tiles.shape[:3], dtype=np.bool_)
        if self._levels:
            np.any(tiles, axis=(3, 4), out=sources)
        pressed = _with_zero(tiles[sources].reshape(-1, self.tile**2))
        displacement = self._sum(pressed, routes(self._levels, sources, np.ones_like(sources)))
        whole = displacement.reshape(tiles.shape).swapaxes(2, 3).reshape(padded.shape)
        return np.ascontiguousarray(whole[:, :rows, :columns]).reshape(pressure.shape)

    def between(self, places: IntArray) -> Callable[[NDArray[Any]], NDArray[Any]]:
        """The operator restricted to some pixels: see :meth:`solver.convolution.Convolution.between`."""
        rows, columns = self.shape
        high, wide = self._grid
        surfaces, count = len(places), self.tile**2
        inside = places < surfaces * rows * columns
        surface, pixel = np.divmod(np.where(inside, places, 0), rows * columns)
        row, column = np.divmod(pixel, columns)
        tile = surface, row // self.tile, column // self.tile
        active = np.full((surfaces, high, wide), not self._levels)
        active[tuple(index[inside] for index in tile)] = True
        ways = routes(self._levels, active, active)
        tiles = np.zeros((int(active.sum()) + 1, count), self.dtype)
        stored = numbered(active)[tile] * count + row % self.tile * self.tile + column % self.tile
        stored[~inside] = tiles.size - 1

        def apply(values: NDArray[Any]) -> NDArray[Any]:
            tiles.ravel()[stored] = values
            tiles[-1] = 0
            displacement: NDArray[Any] = _with_zero(self._sum(tiles, ways)).ravel()[stored]
            return displacement

        return apply

    @cached_property
    def _grid(self) -> Pair:
        return -(-self.shape[0] // self.tile), -(-self.shape[1] // self.tile)

    def _sum(self, tiles: NDArray[Any], ways: list[Route]) -> NDArray[Any]:
        """Displacement of the target tiles, (targets, tile^2), from the pressure of the source tiles and one of zeros."""
        pressures = [tiles]
        for level, route in zip(self._levels, ways, strict=True):
            matrix = level.matrices.restriction
            blocks = np.zeros((route.coarse_sources * level.factors[0] * level.factors[1], matrix.shape[1]), self.dtype)
            _add_products(blocks, route.blocks, pressures[-1], route.block_tiles, matrix)
            pressures.append(_with_zero(blocks.reshape(route.coarse_sources, self.tile**2)))
        side = self._bottom.shape[0]
        displacement: NDArray[Any] = (pressures.pop()[:-1].reshape(-1, side) @ self._bottom).reshape(-1, self.tile**2)
        for level, route, pressure in zip(self._levels[::-1], ways[::-1], pressures[::-1], strict=True):
            matrices = level.matrices
            coarse = _with_zero(displacement.reshape(-1, matrices.restriction.shape[1]))
            displacement = np.zeros((route.targets, self.tile**2), self.dtype)
            _add_products(displacement, np.arange(route.targets), coarse, route.target_blocks, matrices.interpolation)
            _add_products(displacement, route.near_rows, pressure, route.near_tiles, matrices.near)
        return displacement


def _with_zero(tiles: NDArray[Any]) -> NDArray[Any]:
    """The tiles and one more that is zero, which -1 stands for."""
    return np.concatenate([tiles, np.zeros((1, tiles.shape[1]), tiles.dtype)])


def _add_products(
    results: NDArray[Any], rows: IntArray, tiles: NDArray[Any], around: IntArray, matrix: NDArray[Any]
) -> None:
    """Add to the rows of the results the products of the matrix with the 3 x 3 tiles around, (rows, 9)."""

    def add(chunk: slice) -> None:
        pixels = np.take(tiles, around[chunk], axis=0).reshape(-1, matrix.shape[0])
        results[rows[chunk]] += pixels @ matrix

    side_by_side(add, [slice(first, first + CHUNK) for first in range(0, len(rows), CHUNK)])
