"""Surfaces as instruments see them: a rough surface with the form, lay and noise that measured height maps have.

They train the surrogate for real maps, which are rarely as even as synthetic ones: tilted, curved, ground in one direction,
streaked by scan lines, noisy from pixel to pixel, on pixels that are not square.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from solver.problem import FloatArray

ASPECT_RANGE = (1.0, 3.0)
"""dy / dx of pixels that are not square, log-uniform, along either direction."""


def as_measured(surface: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Give a rough surface lay, form and noise, each present in some surfaces and of very different strength.

    Args:
        surface: heights in any unit, shape (rows, columns).
        generator: of the random choices.

    Returns:
        Heights from 0 to 1, same shape.
    """
    heights = (surface - surface.mean()) / surface.std()
    if generator.random() < 0.35:
        lay = gaussian_filter1d(heights, _log_uniform(generator, 0.7, 8.0), axis=int(generator.integers(2)), mode="nearest")
        heights = lay / lay.std()
    y, x = np.meshgrid(*(np.linspace(-1, 1, side) for side in heights.shape), indexing="ij")
    if generator.random() < 0.6:
        direction = generator.uniform(0, 2 * np.pi)
        heights = heights + _log_uniform(generator, 0.3, 100.0) * (np.cos(direction) * x + np.sin(direction) * y)
    if generator.random() < 0.4:
        curvature = generator.uniform(-1, 1, 3)
        form = curvature[0] * x**2 + curvature[1] * y**2 + curvature[2] * x * y
        heights = heights + _log_uniform(generator, 0.3, 30.0) * form
    if generator.random() < 0.5:
        heights = heights + _log_uniform(generator, 0.003, 0.5) * generator.standard_normal(heights.shape)
    if generator.random() < 0.3:
        lines = generator.standard_normal((heights.shape[0], 1))
        heights = heights + _log_uniform(generator, 0.003, 0.3) * lines
    heights -= heights.min()
    normalised: FloatArray = heights / heights.max()
    return normalised


def pixel_aspect(generator: np.random.Generator) -> float:
    """dy / dx: square pixels for every other surface."""
    if generator.random() < 0.5:
        return 1.0
    stretch = _log_uniform(generator, *ASPECT_RANGE)
    return stretch if generator.random() < 0.5 else 1 / stretch


def _log_uniform(generator: np.random.Generator, lowest: float, highest: float) -> float:
    return float(np.exp(generator.uniform(np.log(lowest), np.log(highest))))
