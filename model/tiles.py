"""Large maps in tiles, so that what the network needs in memory is bounded."""

from collections.abc import Iterator
from itertools import product

TILE, OVERLAP = 2048, 128
"""Pixels a side of a tile, and what the network sees around it; both multiples of ``network.MULTIPLE``."""


def tiles(rows: int, columns: int) -> Iterator[tuple[tuple[slice, slice], tuple[slice, slice]]]:
    """What the network sees and what is kept of its answer, tile by tile; a map of up to TILE pixels a side is one."""
    for row, column in product(range(0, rows, TILE), range(0, columns, TILE)):
        seen = tuple(
            slice(max(0, start - OVERLAP), min(side, start + TILE + OVERLAP))
            for start, side in ((row, rows), (column, columns))
        )
        kept = slice(row, min(row + TILE, rows)), slice(column, min(column + TILE, columns))
        yield (seen[0], seen[1]), kept
