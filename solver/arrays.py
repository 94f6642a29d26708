"""Arrays of NumPy on the processor, or of torch on another device: the contact iteration runs on either.

torch is imported only when a device is named.
"""

from typing import Any

import numpy as np
from array_api_compat import array_namespace
from scipy import fft
from scipy.sparse import csr_array

Array = Any
"""A NumPy array or a torch tensor."""

Device = str | None
"""A device of torch; None is the processor, by NumPy."""


_NAMESPACES: dict[type, Any] = {}


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


def moved_matrix(matrix: csr_array, device: Device) -> Any:
    """A sparse matrix on a device, to be applied by ``@``."""
    if device is None:
        return matrix
    import torch

    rows, columns, values = (moved(part, device) for part in (matrix.indptr, matrix.indices, matrix.data))
    return torch.sparse_csr_tensor(rows, columns, values, size=matrix.shape)


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
