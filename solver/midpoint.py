"""Random midpoint displacement: the paper's synthetic rough surfaces."""

import numpy as np

from solver.errors import InvalidProblemError
from solver.problem import FloatArray


def random_midpoint_displacement(size: int, hurst: float = 0.5, seed: int | None = None) -> FloatArray:
    """Self-affine surface by random midpoint displacement (paper section 2.1), normalised to heights from 0 to 1.

    Each level sets the midpoints of the squares, then those of their edges, to the mean of their neighbours plus a normal
    deviate. Its variance, relative to that of the corners, is (1 - 2^(2 hurst - 2)) times 2^(-hurst) to the power of the
    number of steps so far, two a level, as for fractional Brownian motion. The fractal dimension is 3 - hurst (the paper's
    D = 2.5 is hurst = 0.5).

    Args:
        size: pixels a side, a power of two from 4 on.
        hurst: Hurst exponent, from 0 to below 1.
        seed: of the random generator; the same seed gives the same surface.

    Returns:
        Heights in [0, 1], shape (size, size), the last row and column of nodes left out.

    Raises:
        InvalidProblemError: a size that is not a power of two, or a Hurst exponent outside [0, 1).

    Source: Saupe in Peitgen & Saupe, The Science of Fractal Images, 1988, section 2.3 and algorithm MidPointFM2D.
    """
    if size < 4 or size & (size - 1):
        raise InvalidProblemError(f"The size is {size}; it must be a power of two from 4 on.")
    if not 0 <= hurst < 1:
        raise InvalidProblemError(f"The Hurst exponent is {hurst:g}; it must lie in [0, 1).")
    generator = np.random.default_rng(seed)
    nodes = np.zeros((size + 1, size + 1))
    nodes[::size, ::size] = generator.standard_normal((2, 2))
    deviation = np.sqrt(1 - 2.0 ** (2 * hurst - 2))
    step = size
    while step > 1:
        half = step // 2
        deviation *= 0.5 ** (hurst / 2)
        corners = nodes[::step, ::step]
        centres = (corners[:-1, :-1] + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:]) / 4
        nodes[half::step, half::step] = centres + deviation * generator.standard_normal(centres.shape)
        deviation *= 0.5 ** (hurst / 2)
        _displace_edges(nodes, step, half, deviation, generator)
        step = half
    surface = nodes[:-1, :-1]
    surface = surface - surface.min()
    normalised: FloatArray = surface / surface.max()
    return normalised


def _displace_edges(nodes: FloatArray, step: int, half: int, deviation: float, generator: np.random.Generator) -> None:
    """Set the midpoints of all edges to the mean of their three or four neighbours plus a deviate."""
    size = nodes.shape[0]
    padded = np.full((size + 2 * half, size + 2 * half), np.nan)
    padded[half:-half, half:-half] = nodes
    for row, column in ((0, half), (half, 0)):
        rows, columns = np.arange(row, size, step), np.arange(column, size, step)
        at = np.ix_(rows + half, columns + half)
        neighbours = np.stack(
            [
                padded[np.ix_(at[0].ravel() + dr, at[1].ravel() + dc)]
                for dr, dc in ((-half, 0), (half, 0), (0, -half), (0, half))
            ]
        )
        nodes[row::step, column::step] = np.nanmean(neighbours, axis=0) + deviation * generator.standard_normal(
            (rows.size, columns.size)
        )
