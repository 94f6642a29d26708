import numpy as np
import pytest
import torch

from model import Surrogate
from model.attribution import attribution
from model.features import coarse_heights, features, network_input
from solver import ContactProblem, random_midpoint_displacement

HEIGHTS = random_midpoint_displacement(64, seed=21_000_000) * 50e-6
PROBLEM = ContactProblem(HEIGHTS, (1e-3 / 64, 1e-3 / 64), 30.0, 6.843e9)


@pytest.fixture(scope="module")
def surrogate() -> Surrogate:
    return Surrogate.load()


@pytest.fixture(scope="module")
def found(surrogate: Surrogate) -> np.ndarray:
    return attribution(surrogate, PROBLEM)


def test_attributions_add_up_to_what_the_details_add(surrogate: Surrogate, found: np.ndarray) -> None:
    given = features([PROBLEM])
    smooth = type(given)(coarse_heights(given.heights), given.coarse, given.conditions)
    pixels = []
    network = surrogate.weights.network
    for one in (given, smooth):
        with torch.inference_mode():
            logits = network(network_input(one), one.conditions)[:, 0]
        pixels.append(float(torch.sigmoid(logits).sum()))
    assert found.shape == PROBLEM.shape
    assert found.sum() == pytest.approx(pixels[0] - pixels[1], abs=0.1 * np.abs(found).sum())


def test_heights_far_below_the_flat_do_not_matter(surrogate: Surrogate, found: np.ndarray) -> None:
    gap = network_input(features([PROBLEM]))[0, 0].numpy()
    near = np.abs(gap) < 1
    assert np.abs(found[near]).mean() > 5 * np.abs(found[~near]).mean()
