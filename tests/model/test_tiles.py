import numpy as np
import pytest

from model.tiles import OVERLAP, tiles


@pytest.mark.parametrize(("rows", "columns"), [(4096, 100), (2048, 2048), (2049, 4096), (16, 16)])
def test_tiles_cover_the_map_once_and_see_around_them(rows: int, columns: int) -> None:
    covered = np.zeros((rows, columns), dtype=int)
    for seen, kept in tiles(rows, columns):
        covered[kept] += 1
        for window, inner, side in zip(seen, kept, (rows, columns), strict=True):
            assert window.start == max(0, inner.start - OVERLAP)
            assert inner.stop <= window.stop <= side
    assert (covered == 1).all()
