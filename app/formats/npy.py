"""NPY files of NumPy: a plain array of numbers, never objects."""

import io
from tokenize import TokenError

import numpy as np

from app.errors import DamagedFileError, NotAHeightMapError
from app.height_map import HeightMap, check_size


def read_npy(data: bytes) -> HeightMap:
    """Read an array of shape (rows, columns), of integers or floating-point numbers.

    Raises:
        UploadError: one of its subclasses; the message says what to change.
    """
    file = io.BytesIO(data)
    try:
        version = np.lib.format.read_magic(file)
        read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, kind = read_header(file)
        check_size(shape)
        if kind.kind not in "fiu":
            raise NotAHeightMapError(f"The NPY file holds {kind}; heights are integers or floating-point numbers.")
        file.seek(0)
        values = np.lib.format.read_array(file, allow_pickle=False).astype(np.float64)
    except (ValueError, OSError, EOFError, TypeError, OverflowError, SyntaxError, TokenError) as error:
        raise DamagedFileError(f"The NPY file is damaged ({error}). Save it again with numpy.save.") from error
    return HeightMap(np.where(np.isfinite(values), values, np.nan), "NPY")
