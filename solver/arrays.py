"""Arrays of NumPy on the processor, or of torch on another device: the contact iteration runs on either.

torch is imported only when a device is named.
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from array_api_compat import array_namespace
from array_api_compat import numpy as numpy_namespace
from scipy import fft
from scipy.sparse import csr_array

from solver.threads import side_by_side

Array = Any
"""A NumPy array or a torch tensor."""

Device = str | None
"""A device of torch; None is the processor, by NumPy."""

ROWS = 2**15
"""Rows of a sparse matrix multiplied at a time."""

_NAMESPACES: dict[type, Any] = {np.ndarray: numpy_namespace}


def namespace(array: Array) -> Any:
    """The array API for an array: the functions of its library under the names of the standard."""
    kind = type(array)
    if kind not in _NAMESPACES:
        _NAMESPACES[kind] = array_namespace(array)
    return _NAMESPACES[kind]


def moved(array: Any, device: Device) -> Array:
    """A NumPy array on a device."""
    if device is None:
        return array
    import torch

    return torch.as_tensor(array, device=device)


def sparse_product(matrix: csr_array, device: Device) -> Callable[[Array], Array]:
    """The product of a sparse matrix with vectors on a device."""
    if device is not None:
        import torch

        rows, columns, values = (moved(part, device) for part in (matrix.indptr, matrix.indices, matrix.data))
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sparse CSR tensor support is in beta")
            tensor = torch.sparse_csr_tensor(rows, columns, values, size=matrix.shape, check_invariants=False)
        return lambda vector: tensor @ vector
    blocks = [(slice(first, first + ROWS), matrix[first : first + ROWS]) for first in range(0, matrix.shape[0], ROWS)]

    def product(vector: Array) -> Array:
        result = np.empty(matrix.shape[0])

        def multiply(block: tuple[slice, csr_array]) -> None:
            result[block[0]] = block[1] @ vector

        side_by_side(multiply, blocks)
        return result

    return product


def on_processor(array: Array) -> Any:
    """The array as NumPy's."""
    return array if isinstance(array, np.ndarray) else array.cpu().numpy()


def fourier(array: Array) -> Any:
    """The module of Fourier transforms for an array; SciPy's for NumPy's."""
    return fft if isinstance(array, np.ndarray) else namespace(array).fft


def doubled(truths: Array) -> Array:
    """Truth values as numbers in double precision, to multiply by."""
    xp = namespace(truths)
    return xp.astype(truths, xp.float64)
