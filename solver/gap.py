"""The gap that a pressure leaves, whoever proposes it."""

import numpy as np

from solver.convolution import convolution
from solver.problem import ContactProblem, FloatArray


def gap_under(problem: ContactProblem, pressure: FloatArray) -> FloatArray:
    """Gap between the bodies under a pressure, at less than the cost of a certificate: the displacement in single precision.

    Args:
        problem: what touches.
        pressure: in Pa, shape (rows, columns), nowhere negative and somewhere positive.

    Returns:
        In m, same shape, less its mean weighted with the pressure, as in :mod:`solver.certificate`: zero where there is
        pressure and positive elsewhere if the pressure solves the problem.
    """
    dy, dx = problem.pixel_size
    convolve = convolution(problem.boundary, problem.shape, (dy / dx, 1.0), "float32")
    highest = pressure.max()
    displacement = convolve((pressure / highest).astype(np.float32)).astype(np.float64)
    separation = displacement * (highest / problem.effective_modulus * np.sqrt(problem.pixel_area)) + problem.initial_gap
    gap: FloatArray = separation - np.average(separation, weights=pressure)
    return gap
