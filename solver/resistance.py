"""Electrical contact resistance of a contact mask: Boyer's formula, and the potential problem that it approximates."""

import numpy as np
from scipy import fft

from solver.candidates import Candidates
from solver.convolution import convolution
from solver.errors import InvalidMaterialError, InvalidProblemError, NotConvergedError
from solver.problem import BoolArray, FloatArray

SQUARE_SPOT = 0.868
"""Shape factor S of an isothermal square spot, R = S rho / L (Boyer 2001)."""

MOST_ITERATIONS = 1000


def boyer_resistance(mask: BoolArray, pixel_size: tuple[float, float], resistivity: float) -> float:
    """Total constriction resistance of a contact mask by Boyer's pixel formula (paper Eq. 26).

    Every pixel in contact is a square spot; the sum of 1/d over all ordered pairs of pixels is read off the
    autocorrelation of the mask, one zero-padded FFT. Pixels that are not square count as squares of the same area.

    Args:
        mask: where the bodies touch, shape (rows, columns).
        pixel_size: (dy, dx) in m.
        resistivity: mean resistivity of the two bodies, in ohm m.

    Returns:
        R in ohm. Equal current in every pixel is not what flows, so it overestimates: see
        :func:`constriction_resistance`.

    Raises:
        InvalidProblemError: no pixel is in contact.
        InvalidMaterialError: the resistivity is not positive and finite.

    Source: Boyer 2001, doi:10.1109/6144.910801.
    """
    count = _checked_count(mask, resistivity)
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


def constriction_resistance(mask: BoolArray, pixel_size: tuple[float, float], resistivity: float) -> float:
    """Total constriction resistance of a contact mask at one potential, in ohm.

    Args:
        mask: where the bodies touch, shape (rows, columns).
        pixel_size: (dy, dx) in m.
        resistivity: mean resistivity of the two bodies, in ohm m.

    Raises:
        InvalidProblemError: no pixel is in contact.
        InvalidMaterialError: the resistivity is not positive and finite.
        NotConvergedError: see :func:`constriction_current`.

    Source: Barber 2003, doi:10.1098/rspa.2002.1038.
    """
    _checked_count(mask, resistivity)
    side = float(np.sqrt(pixel_size[0] * pixel_size[1]))
    return resistivity / (float(constriction_current(mask, pixel_size).sum()) * side)


def constriction_current(
    mask: BoolArray,
    pixel_size: tuple[float, float],
    tolerance: float = 1e-8,
    initial_current: FloatArray | None = None,
) -> FloatArray:
    """Current density for which the potential is uniform on a contact mask.

    It solves K j = 1 on the mask, with the influence coefficients of the contact problem, by conjugate gradients
    (Hestenes & Stiefel 1952), preconditioned as the contact iteration is.

    Args:
        mask: where the bodies touch, shape (rows, columns).
        pixel_size: (dy, dx) in m.
        tolerance: for the rms deviation of the potential from one on the mask.
        initial_current: a start, as returned for a similar mask, shape (rows, columns).

    Returns:
        Current density under one volt, in units of 1 V / (resistivity * sqrt(dx dy)), zero off the mask.

    Raises:
        NotConvergedError: the tolerance is out of reach.
    """
    spots = Candidates(mask[np.newaxis], pixel_size, convolution("free", mask.shape, pixel_size))
    start = np.zeros(mask.shape) if initial_current is None else initial_current
    current = spots.gather(start[np.newaxis], 0.0)
    everywhere, unit = np.ones_like(current), np.ones(1)
    goal = tolerance * np.sqrt(current.size)
    deviation = 1.0 - spots.convolve(current, unit)
    direction, norm = np.zeros_like(current), np.inf
    for _ in range(MOST_ITERATIONS):
        if np.linalg.norm(deviation) <= goal:
            deviation = 1.0 - spots.convolve(current, unit)
            if np.linalg.norm(deviation) <= goal:
                result: FloatArray = spots.scatter(current)[0]
                return result
            norm = np.inf
        descent = spots.precondition(deviation, everywhere)
        previous, norm = norm, float(np.vdot(descent, deviation))
        direction = descent + (norm / previous) * direction
        response = spots.convolve(direction, unit)
        length = norm / float(np.vdot(direction, response))
        current = current + length * direction
        deviation = deviation - length * response
    raise NotConvergedError(f"The potential deviates by more than {tolerance:g} after {MOST_ITERATIONS} iterations.")


def _checked_count(mask: BoolArray, resistivity: float) -> int:
    """Number of pixels in contact."""
    if not (np.isfinite(resistivity) and resistivity > 0):
        raise InvalidMaterialError(f"The resistivity is {resistivity:g} ohm m; it must be positive and finite.")
    count = int(np.count_nonzero(mask))
    if count == 0:
        raise InvalidProblemError("No pixel is in contact, so the contact resistance is infinite.")
    return count
