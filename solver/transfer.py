"""Transfer between a grid and one with pixels twice as large, for multilevel multi-summation.

Fields are interpolated by centred B-splines on the centres of the coarse pixels, and restricted by the transpose. Splines do
not reproduce polynomials as Lagrange's do, but leave errors a hundred times smaller once the coarse kernel is corrected for
their smoothing; that correction costs nothing later, since the kernel is tabulated.

Offsets count pixels of their own grid; tables hold the offsets from zero on, for all kernels are even.
"""

from functools import cache
from math import comb, factorial

import numpy as np
from scipy.interpolate import BSpline
from scipy.special import zeta

from solver.problem import FloatArray

CORRECTION_TERMS = 6
"""Terms, in powers of the second difference, by which the smoothing of the splines is taken back far from the origin."""

SMOOTHING = [float(zeta(2 * k)) / (k * (2 * np.pi) ** (2 * k)) for k in range(1, CORRECTION_TERMS + 1)]
"""-ln(sin(w/2) / (w/2)) in powers of w^2."""


def fitted_size(tile: int) -> int:
    """Coarse offsets a side below which the kernel is fitted, because the correction there meets the singularity.

    Fewer leave errors, and more are not determined by the pairs that the fit sees.
    """
    return max(tile + 1, 9)


def fit_reach(tile: int) -> int:
    """Fine offsets up to which the fit looks."""
    return 3 * tile


@cache
def spline_weights(order: int, tile: int) -> FloatArray:
    """Weights of the coarse pixels for the fine pixels of a tile, shape (tile, 3 tile / 2).

    The coarse pixels are those under the tile and half a tile's worth on either side.
    """
    spline = BSpline.basis_element(np.arange(order + 1) - order / 2, extrapolate=False)
    fine = (np.arange(tile) + 0.5) / 2
    coarse = np.arange(-tile // 2, tile) + 0.5
    weights: FloatArray = np.nan_to_num(spline(fine[:, np.newaxis] - coarse[np.newaxis, :]))
    return weights


@cache
def _correction(order: int, coarsenings: int) -> FloatArray:
    """Taps of the even filter that takes back the smoothing of all transfers down to a coarse grid, both ways.

    Each coarsening smooths twice by the B-spline's sinc(w/2)^order, w per pixel of its coarse grid. The inverse of the
    product is expanded in y = 4 sin(w/2)^2, the symbol of the negative second difference.
    """
    terms = CORRECTION_TERMS
    frequency = np.array([0.0] + [2 * factorial(k) ** 2 / (k * k * factorial(2 * k)) for k in range(1, terms + 1)])
    exponent, power = np.zeros(terms + 1), np.array([1.0])
    for k, coefficient in enumerate(SMOOTHING, start=1):
        power = np.convolve(power, frequency)[: terms + 1]
        exponent += 2 * order * coefficient * sum(0.25 ** (k * level) for level in range(coarsenings)) * power
    series, term = np.eye(1, terms + 1)[0], np.eye(1, terms + 1)[0]
    for k in range(1, terms + 1):
        term = np.convolve(term, exponent)[: terms + 1] / k
        series = series + term
    taps = np.zeros(2 * terms + 1)
    for k, coefficient in enumerate(series):
        difference = [(-1.0) ** (k - i) * comb(2 * k, i) for i in range(2 * k + 1)]
        taps[terms - k : terms + k + 1] += coefficient * np.array(difference)
    return taps


def corrected(samples: FloatArray, order: int, coarsenings: tuple[int, int]) -> FloatArray:
    """Samples of a smooth kernel on a coarse grid with the smoothing of the splines taken back.

    Args:
        samples: kernel at the coarse offsets, shape (rows + CORRECTION_TERMS, columns + CORRECTION_TERMS).
        order: of the B-splines.
        coarsenings: times that the (rows, columns) have been coarsened.

    Returns:
        Shape (rows, columns); good where the kernel is smooth, that is away from the origin.
    """
    for axis in (0, 1):
        along = np.moveaxis(samples, axis, 0)
        kept = along.shape[0] - CORRECTION_TERMS
        if coarsenings[axis]:
            taps = _correction(order, coarsenings[axis])
            mirrored = np.concatenate([along[CORRECTION_TERMS:0:-1], along])
            along = sum(tap * mirrored[k : k + kept] for k, tap in enumerate(taps))
        samples = np.moveaxis(along[:kept], 0, axis)
    return samples


@cache
def _pair_weights(order: int, factor: int, reach: int) -> tuple[FloatArray, FloatArray]:
    """Weights of the coarse offsets for pairs of fine pixels in one direction.

    Returns:
        Matrix (pairs, coarse offsets) and the fine offset of each pair, up to the reach. With factor 2 a pair is an offset
        and which half of a coarse pixel the first lies in.
    """
    if factor == 1:
        return np.eye(reach + 1), np.arange(reach + 1.0)
    nodes = np.arange(-order, reach)
    spline = BSpline.basis_element(np.arange(order + 1) - order / 2, extrapolate=False)
    rows, offsets = [], []
    for first in (0, 1):
        source = np.nan_to_num(spline((first + 0.5) / 2 - nodes - 0.5))
        for offset in range(reach + 1):
            target = np.nan_to_num(spline((first + offset + 0.5) / 2 - nodes - 0.5))
            pairs = np.zeros(reach + 1)
            distance = np.abs(nodes[:, np.newaxis] - nodes[np.newaxis, :])
            inside = distance <= reach
            np.add.at(pairs, distance[inside], np.outer(source, target)[inside])
            rows.append(pairs)
            offsets.append(float(offset))
    return np.array(rows), np.array(offsets)


@cache
def _fit(order: int, factors: tuple[int, int], tile: int) -> tuple[FloatArray, FloatArray]:
    """Least squares fit of the coarse offsets near the origin to pairs of pixels whose tiles do not touch.

    Returns:
        The pairs' weights, shape (along rows, along columns), and the matrix from their weighted errors to the change of the
        coarse kernel, shape (fitted_size^2, pairs with a weight).
    """
    (along_y, dy), (along_x, dx) = (_pair_weights(order, factor, fit_reach(tile)) for factor in factors)
    apart = 1 - np.outer(1 - np.clip(dy / tile - 1, 0, 1), 1 - np.clip(dx / tile - 1, 0, 1))
    weights, size = np.sqrt(apart), fitted_size(tile)
    pairs = np.einsum("ai,bj->abij", along_y[:, :size], along_x[:, :size])[apart > 0].reshape(-1, size**2)
    return weights, np.linalg.pinv(pairs * weights[apart > 0][:, np.newaxis], rcond=1e-15)


def fitted(coarse: FloatArray, fine: FloatArray, order: int, factors: tuple[int, int], tile: int) -> FloatArray:
    """The coarse kernel near the origin, chosen so that it, interpolated both ways, meets the fine kernel.

    It is the least squares fit over the pairs of pixels whose tiles do not touch; those of touching tiles are summed
    exactly, whatever the coarse kernel.

    Args:
        coarse: kernel at the coarse offsets, good away from the origin, at least ``fit_reach(tile)`` + 1 each way.
        fine: kernel at the fine offsets, as many.
        order: of the B-splines.
        factors: 2 in the directions that are coarsened, 1 in the other.
        tile: pixels a side of a tile.

    Returns:
        Shape (fitted_size(tile), fitted_size(tile)).
    """
    (along_y, dy), (along_x, dx) = (_pair_weights(order, factor, fit_reach(tile)) for factor in factors)
    size_y, size_x, size = along_y.shape[1], along_x.shape[1], fitted_size(tile)
    weights, solution = _fit(order, factors, tile)
    error = fine[np.ix_(dy.astype(int), dx.astype(int))] - along_y @ coarse[:size_y, :size_x] @ along_x.T
    change = solution @ (error * weights)[weights > 0]
    result: FloatArray = coarse[:size, :size] + change.reshape(size, size)
    return result
