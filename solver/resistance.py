"""Electrical contact resistance of a contact mask."""

import numpy as np
from scipy import fft

from solver.errors import InvalidMaterialError, InvalidProblemError
from solver.problem import BoolArray

SQUARE_SPOT = 0.868
"""Shape factor S of an isothermal square spot, R = S rho / L (Boyer 2001)."""


def boyer_resistance(mask: BoolArray, pixel_size: tuple[float, float], resistivity: float) -> float:
    """Total constriction resistance of a contact mask by Boyer's pixel formula (paper Eq. 26).

    Every pixel in contact is a square spot; the sum of 1/d over all ordered pairs of pixels is read off the
    autocorrelation of the mask, one zero-padded FFT. Pixels that are not square count as squares of the same area.

    Args:
        mask: where the bodies touch, shape (rows, columns).
        pixel_size: (dy, dx) in m.
        resistivity: mean resistivity of the two bodies, in ohm m.

    Returns:
        R in ohm. Equal current in every pixel is not what flows, so it overestimates: see docs/conventions.md.

    Raises:
        InvalidProblemError: no pixel is in contact.
        InvalidMaterialError: the resistivity is not positive and finite.

    Source: Boyer 2001, doi:10.1109/6144.910801.
    """
    if not (np.isfinite(resistivity) and resistivity > 0):
        raise InvalidMaterialError(f"The resistivity is {resistivity:g} ohm m; it must be positive and finite.")
    count = int(np.count_nonzero(mask))
    if count == 0:
        raise InvalidProblemError("No pixel is in contact, so the contact resistance is infinite.")
    dy, dx = pixel_size
    side = np.sqrt(dy * dx)
    rows, columns = mask.shape
    padded = fft.next_fast_len(2 * rows - 1), fft.next_fast_len(2 * columns - 1, real=True)
    transform = fft.rfft2(mask.astype(np.float64), s=padded)
    pairs = np.rint(fft.irfft2(np.abs(transform) ** 2, s=padded))[:rows, :]
    pairs[1:] *= 2
    row_distance = np.arange(rows)[:, np.newaxis] * dy
    column_distance = np.minimum(np.arange(padded[1]), padded[1] - np.arange(padded[1]))[np.newaxis, :] * dx
    distance = np.hypot(row_distance, column_distance)
    distance[0, 0] = np.inf
    return resistivity * float(SQUARE_SPOT / (count * side) + (pairs / distance).sum() / (np.pi * count**2))
