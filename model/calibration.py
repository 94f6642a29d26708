"""The error to expect of a prediction, from what it tells of itself: fitted on held-out surfaces.

An error is, on average, a power of the doubt, and another one where few pixels touch; nine in ten errors stay below a
multiple of that. Powers of the load and of the pixels would fit the synthetic surfaces better, and measured ones far worse.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize

from solver.problem import FloatArray

Calibration = dict[str, dict[str, Any]]
"""For each quantity the ``coefficients`` of the predictors and the ``factor`` from the mean to the bound."""

QUANTITIES = ("dice", "contact_area", "contact_resistance")
COVERED = 0.9
LEAST = 1e-4
"""Doubts, and mean errors, below this count as this."""

LARGEST_LOG = 50.0


@dataclass(frozen=True)
class ErrorBar:
    """An error as it is expected.

    Attributes:
        expected: its mean.
        bound: what nine in ten errors stay below.
    """

    expected: float
    bound: float


@dataclass(frozen=True)
class Evidence:
    """What a prediction tells of its own error.

    Attributes:
        doubt: 1 - Dice between the pixels under pressure and the active set that they and the gap under that pressure
            tell; for the network 1 - Dice that it expects itself is added.
        contact_pixels: of the predicted mask.
    """

    doubt: float
    contact_pixels: int


def calibrated(evidence: Sequence[Evidence], errors: Mapping[str, Sequence[float]]) -> Calibration:
    """Fit the errors found on held-out surfaces; those above one count as one.

    Args:
        evidence: of the predictions.
        errors: for each of ``QUANTITIES`` what the predictions were wrong by.
    """
    design = np.array([_predictors(one) for one in evidence])
    found: Calibration = {}
    for quantity in QUANTITIES:
        error = np.minimum(errors[quantity], 1.0)
        coefficients = _poisson(design, error)
        factor = np.quantile(error / np.exp(design @ coefficients), COVERED)
        found[quantity] = {"coefficients": coefficients.tolist(), "factor": float(factor)}
    return found


def error_bars(evidence: Evidence, calibration: Calibration) -> dict[str, ErrorBar]:
    """The error to expect of each quantity; at most one, which says that nothing is known."""
    predictors = _predictors(evidence)
    bars = {}
    for quantity in QUANTITIES:
        fitted = calibration[quantity]
        expected = min(float(np.exp(predictors @ np.asarray(fitted["coefficients"]))), 1.0)
        bars[quantity] = ErrorBar(expected, min(expected * float(fitted["factor"]), 1.0))
    return bars


def _poisson(design: FloatArray, error: FloatArray) -> FloatArray:
    """The mean by Poisson regression, which bears errors of exactly zero and leaves the overall mean right."""

    def deviance(coefficients: FloatArray) -> tuple[float, FloatArray]:
        logarithm = design @ coefficients
        mean = np.exp(np.minimum(logarithm, LARGEST_LOG))
        return float((mean - error * logarithm).mean()), design.T @ (mean - error) / len(error)

    start = np.zeros(design.shape[1])
    start[0] = np.log(max(error.mean(), LEAST))
    coefficients: FloatArray = minimize(deviance, start, jac=True, method="BFGS").x
    return coefficients


def _predictors(evidence: Evidence) -> FloatArray:
    return np.array([1.0, np.log(max(evidence.doubt, LEAST)), max(evidence.contact_pixels, 1) ** -0.5])
