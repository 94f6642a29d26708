"""Fields as NPY files: every bit, and never a pickle."""

import io

import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float64] | NDArray[np.float32] | NDArray[np.bool_]
"""Shape (rows, columns)."""


def npy(values: Field) -> bytes:
    """As an NPY file."""
    file = io.BytesIO()
    np.save(file, values, allow_pickle=False)
    return file.getvalue()


def from_npy(data: bytes) -> Field:
    """From an NPY file of ours."""
    field: Field = np.load(io.BytesIO(data), allow_pickle=False)
    return field
