"""The same problem on a coarser grid."""

import numpy as np

from solver.problem import ContactProblem, FloatArray


def coarsened(problem: ContactProblem, factor: int) -> ContactProblem:
    """The problem on the means of factor x factor pixels; the last rows and columns are repeated to fill the last blocks."""
    rows, columns = problem.shape
    heights = np.pad(problem.heights, ((0, -rows % factor), (0, -columns % factor)), mode="edge")
    blocks = heights.reshape(heights.shape[0] // factor, factor, heights.shape[1] // factor, factor)
    dy, dx = problem.pixel_size
    return ContactProblem(
        heights=blocks.mean(axis=(1, 3)),
        pixel_size=(dy * factor, dx * factor),
        load=problem.load,
        effective_modulus=problem.effective_modulus,
        boundary=problem.boundary,
    )


def prolonged(field: FloatArray, factor: int, shape: tuple[int, int]) -> FloatArray:
    """A coarse field repeated onto the finer grid, shape (rows, columns)."""
    return field.repeat(factor, axis=0).repeat(factor, axis=1)[: shape[0], : shape[1]]
