"""Pressure by displacement where (nearly) all pixels touch: the filter |q| / 2, |q| the wave number.

On a periodic surface it is the inverse of the displacement; on an isolated patch, mirrored at its edges, it is close, and a
far better preconditioner in full contact than the stencil of :mod:`solver.candidates`, which is better in partial contact.

Source: Johnson, Contact Mechanics, section 13.2 (u = 2 p / (E* |q|)); Stanley & Kato 1997, doi:10.1115/1.2833523.
"""

from collections.abc import Callable

import numpy as np
from scipy import fft

from solver.problem import Boundary, FloatArray

Filter = Callable[[FloatArray], FloatArray]

LOWEST_WAVES = 0.5
"""Wave number at which the mean of an isolated patch counts, in half waves along its side."""


def full_contact_filter(boundary: Boundary, shape: tuple[int, int], pixel_size: tuple[float, float]) -> Filter:
    """The filter for fields of shape (..., rows, columns), in units of :mod:`solver.influence`."""
    rows, columns = shape
    height, width = np.sqrt(pixel_size[0] / pixel_size[1]), np.sqrt(pixel_size[1] / pixel_size[0])
    if boundary == "periodic":
        q = np.hypot(2 * np.pi * fft.fftfreq(rows, height)[:, np.newaxis], 2 * np.pi * fft.rfftfreq(columns, width))
        q[0, 0] = min(q[0, 1], q[1, 0])
        half = q / 2

        def periodic(field: FloatArray) -> FloatArray:
            result: FloatArray = fft.irfft2(fft.rfft2(field) * half, s=shape)
            return result

        return periodic

    along_rows, along_columns = np.pi / (rows * height), np.pi / (columns * width)
    q = np.hypot(along_rows * np.arange(rows)[:, np.newaxis], along_columns * np.arange(columns))
    q += LOWEST_WAVES * min(along_rows, along_columns)

    half_single = (q / 2).astype(np.float32)

    def free(field: FloatArray) -> FloatArray:
        transform = fft.dctn(field.astype(np.float32), axes=(-2, -1), overwrite_x=True)
        transform *= half_single
        return fft.idctn(transform, axes=(-2, -1), overwrite_x=True).astype(np.float64)

    return free
