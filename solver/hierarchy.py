"""The grids of the multilevel sum, each with pixels twice as large as the last, and the matrices that lead between them."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.influence import free_coefficients
from solver.problem import FloatArray, IntArray
from solver.transfer import CORRECTION_TERMS, corrected, fit_reach, fitted, spline_weights

Pair = tuple[int, int]

MOST_BOTTOM_TILES = 9
"""Tiles at which the recursion ends in one dense matrix."""

COARSEN_BELOW = 1.5
"""The direction with the larger spacing is coarsened too if it is within this factor of the other."""

AROUND = [(row, column) for row in (-1, 0, 1) for column in (-1, 0, 1)]
"""Places of the tiles around a tile, itself included."""


@dataclass(frozen=True, eq=False)
class Matrices:
    """What one level applies to tiles; rows are the pixels of the 3 x 3 tiles (or blocks) around.

    Attributes:
        near: (9 tile^2, tile^2), influence of touching tiles, less what the coarse grid says of them.
        restriction: (9 tile^2, block), to the coarse pixels under a tile.
        interpolation: (9 block, tile^2), from the coarse pixels.
    """

    near: NDArray[Any]
    restriction: NDArray[Any]
    interpolation: NDArray[Any]


@dataclass(frozen=True)
class Level:
    """One grid of the hierarchy.

    Attributes:
        tiles: tiles along (rows, columns).
        factors: 2 in the directions in which the next grid is coarser, 1 in the other.
        matrices: of its tiles.
    """

    tiles: Pair
    factors: Pair
    matrices: Matrices

    @property
    def margin(self) -> Pair:
        """Tiles by which the coarse grid reaches out on each side, for the splines."""
        return self.factors[0] - 1, self.factors[1] - 1


@lru_cache(maxsize=8)
def hierarchy(shape: Pair, aspect: float, precision: str, order: int, tile: int) -> tuple[list[Level], NDArray[Any]]:
    """The levels of a grid from fine to coarse, and the matrix of all pairs of pixels on the grid below them."""
    tiles = -(-shape[0] // tile), -(-shape[1] // tile)
    factors: list[Pair] = []
    levels = []
    while tiles[0] * tiles[1] > MOST_BOTTOM_TILES:
        step = _step(factors, aspect)
        factors.append(step)
        levels.append(Level(tiles, step, _matrices(tuple(factors), aspect, precision, order, tile)))
        tiles = -(-(tiles[0] + 2 * step[0] - 2) // step[0]), -(-(tiles[1] + 2 * step[1] - 2) // step[1])
    kernel = _kernel(tuple(factors), aspect, order, tile, (tiles[0] * tile, tiles[1] * tile))
    pixels = _storage_order(factors[-1] if factors else (1, 1), tile)
    row, column = (np.arange(count) * tile for count in tiles)
    rows = (row[:, np.newaxis, np.newaxis] + pixels[:, 0] + 0 * column[np.newaxis, :, np.newaxis]).ravel()
    columns = (column[np.newaxis, :, np.newaxis] + pixels[:, 1] + 0 * row[:, np.newaxis, np.newaxis]).ravel()
    bottom = kernel[np.abs(np.subtract.outer(rows, rows)), np.abs(np.subtract.outer(columns, columns))]
    return levels, bottom.astype(precision)


def _step(factors: list[Pair], aspect: float) -> Pair:
    """The direction of the smaller spacing is coarsened, and the other if it is not much larger."""
    spacing = [aspect, 1.0]
    for factor in factors:
        spacing = [spacing[0] * factor[0], spacing[1] * factor[1]]
    return (
        2 if spacing[0] <= COARSEN_BELOW * spacing[1] else 1,
        2 if spacing[1] <= COARSEN_BELOW * spacing[0] else 1,
    )


def _kernel(factors: tuple[Pair, ...], aspect: float, order: int, tile: int, shape: Pair) -> FloatArray:
    """The kernel of the grid below some coarsenings, at the offsets from zero on."""
    kernel = _sampled(factors, aspect, order, shape)
    if factors:
        near = _near_origin(factors, aspect, order, tile)[: shape[0], : shape[1]]
        kernel[: near.shape[0], : near.shape[1]] = near
    return kernel


def _sampled(factors: tuple[Pair, ...], aspect: float, order: int, shape: Pair) -> FloatArray:
    """What :func:`_kernel` is far from the origin."""
    rows, columns = (int(np.prod([factor[axis] for factor in factors])) for axis in (0, 1))
    reach = shape[0] + CORRECTION_TERMS, shape[1] + CORRECTION_TERMS
    samples = free_coefficients(reach, (aspect, 1.0), (rows, columns))
    return corrected(samples, order, (rows.bit_length() - 1, columns.bit_length() - 1))


@lru_cache(maxsize=64)
def _near_origin(factors: tuple[Pair, ...], aspect: float, order: int, tile: int) -> FloatArray:
    """What :func:`_kernel` is near the origin of a grid that has been coarsened."""
    shape = fit_reach(tile) + 1, fit_reach(tile) + 1
    fine = _kernel(factors[:-1], aspect, order, tile, shape)
    return fitted(_sampled(factors, aspect, order, shape), fine, order, factors[-1], tile)


@lru_cache(maxsize=64)
def _matrices(factors: tuple[Pair, ...], aspect: float, precision: str, order: int, tile: int) -> Matrices:
    """The matrices of a level, whose coarsening is the last of the factors; they do not depend on the size of the grid."""
    block = tile // factors[-1][0], tile // factors[-1][1]
    fine = _kernel(factors[:-1], aspect, order, tile, (2 * tile, 2 * tile))
    coarse = _kernel(factors, aspect, order, tile, (4 * tile, 4 * tile))
    high, wide = (spline_weights(order, tile) if factor == 2 else np.eye(tile, 3 * tile, tile) for factor in factors[-1])
    near = np.empty((9, tile, tile, tile, tile))
    for around, (down, right) in enumerate(AROUND):
        exact = fine[_distances(tile, down * tile)[:, :, np.newaxis, np.newaxis], _distances(tile, right * tile)]
        rows = _distances(3 * block[0], down * block[0])
        columns = _distances(3 * block[1], right * block[1])
        between = coarse[rows[:, :, np.newaxis, np.newaxis], columns]
        said = np.einsum("tI,sK,KILJ,uJ,vL->stvu", high, high, between, wide, wide, optimize=True)
        near[around] = (exact - said).transpose(0, 2, 1, 3)
    pixels = _storage_order(factors[-2] if len(factors) > 1 else (1, 1), tile)
    row, column = pixels[:, 0], pixels[:, 1]
    near_matrix = near[:, row, column][:, :, row, column].reshape(9 * tile**2, tile**2)
    blocks_high, blocks_wide = high.reshape(tile, 3, block[0]), wide.reshape(tile, 3, block[1])
    interpolation = np.einsum("tgi,uhj->ghijtu", blocks_high, blocks_wide)[..., row, column]
    restriction = np.einsum("tgi,uhj->ghtuij", blocks_high[:, ::-1], blocks_wide[:, ::-1])[:, :, row, column]
    size = block[0] * block[1]
    return Matrices(
        near=near_matrix.astype(precision),
        restriction=restriction.reshape(9 * tile**2, size).astype(precision),
        interpolation=np.ascontiguousarray(interpolation.reshape(9 * size, tile**2)).astype(precision),
    )


def _distances(count: int, shift: int) -> IntArray:
    """|source + shift - target| for sources (rows) and targets (columns) within a tile."""
    distances: IntArray = np.abs(np.arange(count)[:, np.newaxis] + shift - np.arange(count)[np.newaxis, :])
    return distances


def _storage_order(factors: Pair, tile: int) -> IntArray:
    """(row, column) of the pixels of a tile as stored: block by block, as the finer level fills them."""
    high, wide = tile // factors[0], tile // factors[1]
    order = [
        (down * high + row, right * wide + column)
        for down in range(factors[0])
        for right in range(factors[1])
        for row in range(high)
        for column in range(wide)
    ]
    return np.array(order)
