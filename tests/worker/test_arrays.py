"""Arrays as files."""

import numpy as np
import pytest

from worker.arrays import from_npy, npy

VALUES = np.random.default_rng(0).random((5, 7)) * 3e9 - 1e9


@pytest.mark.parametrize("values", [VALUES, VALUES.astype(np.float32), VALUES > 0])
def test_npy_keeps_every_bit(values: np.ndarray) -> None:
    back = from_npy(npy(values))
    assert back.dtype == values.dtype
    np.testing.assert_array_equal(back, values)
