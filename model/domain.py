"""What the network was trained on, in a few statistics of a problem, and whether another problem lies within."""

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

from model.features import TYPICAL_LOG_LOAD, Features, coarse_heights

STATISTICS = {
    "load": "the load, log10 F / (E* A0 rms slope),",
    "aspect": "the aspect of the pixels, ln dy / dx,",
    "detail": "the roughness within coarse pixels, its logarithm relative to the slope,",
    "skewness": "the skewness of the heights",
    "kurtosis": "the kurtosis of the heights, its logarithm,",
}
"""By name, what a reason calls them."""

COVERED = 0.999
"""Share of the training problems within the domain, in each statistic."""


def statistics(given: Features) -> Tensor:
    """The statistics of problems, shape (problems, statistics)."""
    heights = given.heights
    centred = heights - heights.mean(dim=(1, 2), keepdim=True)
    detail = (heights - coarse_heights(heights)).square().mean(dim=(1, 2)).sqrt()
    squared = centred.square()
    second, third, fourth = (field.mean(dim=(1, 2)) for field in (squared, squared * centred, squared.square()))
    columns = [
        given.conditions[:, 0] + TYPICAL_LOG_LOAD,
        given.conditions[:, 1],
        detail.clamp_min(1e-6).log10(),
        third / second.pow(1.5),
        (fourth / second.square()).log10(),
    ]
    return torch.stack(columns, dim=1)


def domain_of(trained: Tensor) -> dict[str, list[float]]:
    """The range of each statistic, from those of the training problems, shape (problems, statistics)."""
    tail = (1 - COVERED) / 2
    lowest, highest = (torch.quantile(trained.double(), share, dim=0).tolist() for share in (tail, 1 - tail))
    return {name: [low, high] for name, low, high in zip(STATISTICS, lowest, highest, strict=True)}


def outside(found: Tensor, domain: Mapping[str, Sequence[float]]) -> tuple[str, ...]:
    """Why a problem with these statistics, shape (statistics,), lies outside a domain; empty if it lies within."""
    reasons = []
    for value, (name, (lowest, highest)) in zip(found.tolist(), domain.items(), strict=True):
        if not lowest <= value <= highest:
            reasons.append(f"{STATISTICS[name]} is {value:.2f}, not {lowest:.2f} to {highest:.2f} as in training")
    return tuple(reasons)
