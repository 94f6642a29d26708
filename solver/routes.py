"""Where the tiles of a multilevel sum find each other: which are needed on each grid, and which lie around which.

Tiles without pressure, and those whose displacement nobody asks for, appear in no route.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from solver.hierarchy import AROUND, Level, Pair
from solver.problem import BoolArray, IntArray


@dataclass(frozen=True)
class Route:
    """Where the tiles of one level find each other; -1 stands for one that is zero.

    Attributes:
        targets: number of tiles whose displacement is wanted.
        near_rows: those of them with pressure around, and ``near_tiles``: the tiles around these, (rows, 9).
        blocks: places in the coarse storage that receive pressure, ``block_tiles`` the tiles around them, (blocks, 9).
        target_blocks: the coarse places around each target, (targets, 9).
        coarse_sources: tiles stored on the next level.
    """

    targets: int
    near_rows: IntArray
    near_tiles: IntArray
    blocks: IntArray
    block_tiles: IntArray
    target_blocks: IntArray
    coarse_sources: int


def numbered(active: BoolArray) -> IntArray:
    """The number of each active tile in order, -1 elsewhere."""
    numbers = np.full(active.shape, -1, dtype=np.intp)
    numbers[active] = np.arange(np.count_nonzero(active))
    return numbers


def _neighbours(numbers: IntArray, margin: Pair, places: tuple[IntArray, ...], shift: Pair) -> IntArray:
    """Numbers of the 3 x 3 tiles around places of a grid that reaches ``shift`` further out, (places, 9)."""
    padded = np.pad(numbers, ((0, 0), (1 + margin[0],) * 2, (1 + margin[1],) * 2), constant_values=-1)
    surface, row, column = places
    row, column = row + 1 + margin[0] + shift[0], column + 1 + margin[1] + shift[1]
    return np.stack([padded[surface, row + down, column + right] for down, right in AROUND], axis=1)


def routes(levels: list[Level], sources: BoolArray, targets: BoolArray) -> list[Route]:
    """Routes of all levels for tiles with pressure and tiles whose displacement is wanted, (surfaces, high, wide).

    Below the last level, where one matrix sums all, every tile is stored.
    """
    result = []
    for level in levels:
        route, sources, targets = _route(level, sources, targets, last=level is levels[-1])
        result.append(route)
    return result


def _route(level: Level, sources: BoolArray, targets: BoolArray, last: bool) -> tuple[Route, BoolArray, BoolArray]:
    """The route of one level, and the tiles of the next that carry pressure and whose displacement is wanted."""
    margin, factors = level.margin, level.factors
    numbers = numbered(sources)
    wanted = np.nonzero(targets)
    near_tiles = _neighbours(numbers, (0, 0), wanted, (0, 0))
    near_rows = np.flatnonzero((near_tiles >= 0).any(axis=1))

    receiving, giving = _spread(sources, margin), _spread(targets, margin)
    coarse_sources, coarse_targets = _grouped(receiving, factors), _grouped(giving, factors)
    if last:
        coarse_sources[:], coarse_targets[:] = True, True
    blocks = np.nonzero(receiving)
    route = Route(
        targets=len(wanted[0]),
        near_rows=near_rows,
        near_tiles=near_tiles[near_rows],
        blocks=_block_places(coarse_sources, receiving.shape, factors)[blocks],
        block_tiles=_neighbours(numbers, margin, blocks, (-margin[0], -margin[1])),
        target_blocks=_neighbours(_block_places(coarse_targets, giving.shape, factors), (0, 0), wanted, margin),
        coarse_sources=int(coarse_sources.sum()),
    )
    return route, coarse_sources, coarse_targets


def _spread(active: BoolArray, margin: Pair) -> BoolArray:
    """The blocks that splines of the active tiles reach: one further out in the coarsened directions."""
    down, right = margin
    padded = np.pad(active, ((0, 0), (down, down), (right, right)))
    reached: BoolArray = ndimage.binary_dilation(padded, np.ones((1, 1 + 2 * down, 1 + 2 * right), dtype=np.bool_))
    return reached


def _grouped(blocks: BoolArray, factors: Pair) -> BoolArray:
    """The coarse tiles that hold any of the blocks."""
    batch, high, wide = blocks.shape
    padded = np.pad(blocks, ((0, 0), (0, -high % factors[0]), (0, -wide % factors[1])))
    split = padded.reshape(batch, padded.shape[1] // factors[0], factors[0], padded.shape[2] // factors[1], factors[1])
    grouped: BoolArray = np.logical_or.reduce(split, axis=(2, 4))
    return grouped


def _block_places(coarse: BoolArray, shape: tuple[int, ...], factors: Pair) -> IntArray:
    """Where each block of a grid of blocks lies in the storage of the coarse tiles, -1 where its tile is not stored."""
    numbers = numbered(coarse).repeat(factors[0], axis=1).repeat(factors[1], axis=2)[:, : shape[1], : shape[2]]
    row, column = np.arange(shape[1])[:, np.newaxis] % factors[0], np.arange(shape[2])[np.newaxis, :] % factors[1]
    places: IntArray = np.where(numbers >= 0, numbers * (factors[0] * factors[1]) + row * factors[1] + column, -1)
    return places
