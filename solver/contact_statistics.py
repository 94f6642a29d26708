"""What engineers read off a solved contact: areas, spots, pressures, gaps and energy."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from solver.problem import BoolArray, Boundary, ContactProblem, FloatArray
from solver.solution import Solution

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Levels of the quantiles."""

PERIMETER_SHARE = (np.pi - 1 + np.log(2)) / 24
"""Share of a pixel by which each of its edges on the contact's outline makes the count of pixels too large."""


@dataclass(frozen=True)
class Distribution:
    """Values over some pixels; all zero if there are none.

    Attributes:
        mean, rms, largest: of the values.
        quantiles: at the levels of ``LEVELS``.
    """

    mean: float
    rms: float
    largest: float
    quantiles: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class ContactStatistics:
    """A solved contact in numbers.

    Attributes:
        pixel_area: pixels in contact times the area of a pixel, in m^2.
        corrected_area: the same less what pixels on the outline count too much, in m^2.
        spot_areas: of each contact spot, pixels that share edges, in m^2, largest first.
        pressure: over the pixels in contact, in Pa.
        gap: over the other pixels, in m.
        mean_gap: over all pixels, in m.
        elastic_energy: 1/2 of the integral of pressure times displacement, in J; on a periodic surface that of the
            displacement about its mean.
    """

    pixel_area: float
    corrected_area: float
    spot_areas: FloatArray
    pressure: Distribution
    gap: Distribution
    mean_gap: float
    elastic_energy: float


def contact_statistics(problem: ContactProblem, solution: Solution) -> ContactStatistics:
    """Measure a solved contact."""
    mask = solution.contact_mask
    spot_pixels = np.bincount(contact_spots(mask, problem.boundary)[mask])[1:].astype(np.float64)
    displacement = solution.gap + solution.approach - problem.initial_gap
    return ContactStatistics(
        pixel_area=float(mask.sum()) * problem.pixel_area,
        corrected_area=corrected_area(mask, problem.pixel_area, problem.boundary),
        spot_areas=np.sort(spot_pixels)[::-1] * problem.pixel_area,
        pressure=_distribution(solution.pressure[mask]),
        gap=_distribution(solution.gap[~mask]),
        mean_gap=float(solution.gap.mean()),
        elastic_energy=float(np.vdot(solution.pressure, displacement)) * problem.pixel_area / 2,
    )


def corrected_area(mask: BoolArray, pixel_area: float, boundary: Boundary) -> float:
    """Real area of contact in m^2, with the outline's share taken off.

    Pixels on the outline count whole though the contact covers only part of them, which overestimates the area in
    proportion to the perimeter.

    Args:
        mask: p > 0 in a solution, shape (rows, columns).
        pixel_area: in m^2.
        boundary: on a periodic surface the outline goes on at the opposite edge.

    Source: Yastrebov, Anciaux & Molinari 2017, doi:10.1016/j.triboint.2017.04.023.
    """
    edges = sum(np.count_nonzero(np.diff(mask, axis=axis)) for axis in (0, 1))
    if boundary == "periodic":
        edges += np.count_nonzero(mask[0] != mask[-1]) + np.count_nonzero(mask[:, 0] != mask[:, -1])
    return float(mask.sum() - PERIMETER_SHARE * edges) * pixel_area


def contact_spots(mask: BoolArray, boundary: Boundary) -> np.ndarray[tuple[int, ...], np.dtype[np.int32]]:
    """Number of the contact spot that each pixel belongs to, from 1, and 0 off contact; shape (rows, columns).

    A spot is a set of pixels that share edges; on a periodic surface it goes on at the opposite edge of the map.
    """
    spots, count = ndimage.label(mask)
    if boundary == "free" or count == 0:
        return np.asarray(spots, dtype=np.int32)
    pairs = np.concatenate([np.stack([spots[0], spots[-1]]), np.stack([spots[:, 0], spots[:, -1]])], axis=1)
    joined = pairs[:, (pairs > 0).all(axis=0)]
    graph = coo_array((np.ones(joined.shape[1]), (joined[0] - 1, joined[1] - 1)), shape=(count, count))
    _, numbers = connected_components(graph, directed=False)
    return np.concatenate([[0], numbers + 1]).astype(np.int32)[spots]


def conductance_per_area(resistance: float, problem: ContactProblem) -> float:
    """Conductance of a contact by its nominal area, in S/m^2, from its resistance in ohm."""
    return 1 / (resistance * problem.nominal_area)


def _distribution(values: FloatArray) -> Distribution:
    if values.size == 0:
        return Distribution(0.0, 0.0, 0.0, (0.0,) * len(LEVELS))
    return Distribution(
        mean=float(values.mean()),
        rms=float(np.sqrt(np.mean(values**2))),
        largest=float(values.max()),
        quantiles=tuple(float(value) for value in np.quantile(values, LEVELS)),
    )
