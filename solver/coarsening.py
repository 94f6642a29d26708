"""The same problem on a coarser grid."""

from dataclasses import replace

from solver.arrays import Array, namespace
from solver.problem import ContactProblem


def coarsened(problem: ContactProblem, factor: int) -> ContactProblem:
    """The problem on the means of factor x factor pixels."""
    dy, dx = problem.pixel_size
    return replace(problem, heights=block_means(problem.heights, factor), pixel_size=(dy * factor, dx * factor))


def block_means(field: Array, factor: int) -> Array:
    """Means of factor x factor pixels, shape (..., rows, columns); the last ones are repeated to fill the last blocks."""
    xp = namespace(field)
    for axis in (-2, -1):
        side = field.shape[axis]
        if side % factor:
            last = xp.take(field, xp.asarray([side - 1] * (-side % factor)), axis=axis)
            field = xp.concat([field, last], axis=axis)
    rows, columns = field.shape[-2:]
    split = xp.reshape(field, (*field.shape[:-2], rows // factor, factor, columns // factor, factor))
    return xp.mean(split, axis=(-3, -1))


def prolonged(field: Array, factor: int, shape: tuple[int, int]) -> Array:
    """A coarse field, shape (..., rows, columns), repeated onto the finer grid with (rows, columns) of ``shape``."""
    xp = namespace(field)
    return xp.repeat(xp.repeat(field, factor, axis=-2), factor, axis=-1)[..., : shape[0], : shape[1]]
