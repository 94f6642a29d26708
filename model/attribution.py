"""Which heights moved the answer: integrated gradients of the predicted contact area.

The baseline is the map as the coarse grid sees it, so what is explained is the work of the network on the fine heights.

Source: Sundararajan, Taly & Yan 2017, Axiomatic attribution for deep networks, arXiv:1703.01365, by the package captum
(``pip install 'asperity[attribution]'``).
"""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from model.errors import AttributionError
from model.features import coarse_heights, features, network_input
from model.surrogate import Surrogate
from solver.problem import ContactProblem, FloatArray

STEPS = 32
"""Points of the integral between baseline and map."""


def attribution(surrogate: Surrogate, problem: ContactProblem) -> FloatArray:
    """How many pixels of predicted contact the height of each pixel adds or takes away; they sum to what the details add.

    Args:
        surrogate: whose network is explained.
        problem: that the network can answer, see :func:`model.features.features`.

    Returns:
        Shape (rows, columns), in pixels of contact.

    Raises:
        AttributionError: captum is not installed.
    """
    try:
        from captum.attr import IntegratedGradients
    except ImportError as error:
        raise AttributionError("Attributions need the package captum: pip install 'asperity[attribution]'.") from error
    given = features([problem])
    network = deepcopy(surrogate.weights.network).float()

    def contact_pixels(heights: Tensor) -> Tensor:
        several = (len(heights), *[-1] * 3)
        fields = network_input(replace(given, heights=heights, coarse=given.coarse.expand(several)))
        logits = network(fields, given.conditions.expand(len(heights), -1))[:, 0]
        return torch.sigmoid(logits).sum(dim=(1, 2))

    found = IntegratedGradients(contact_pixels).attribute(
        given.heights, baselines=coarse_heights(given.heights), n_steps=STEPS, internal_batch_size=1
    )
    result: FloatArray = found[0].detach().numpy().astype(np.float64)
    return result
