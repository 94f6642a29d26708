"""The error to expect of a prediction, from what it tells of itself: fitted on held-out surfaces.

An error is, on average, a power of the doubt, of the pixels in contact and of the dimensionless load; nine in ten errors
stay below a multiple of that.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize

from solver.problem import FloatArray

Calibration = dict[str, dict[str, Any]]
"""For each quantity ``powers`` of the predictors and the ``factor`` from the mean to the bound."""

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
        doubt: 1 - Dice that the network itself expects, or that a solve which stopped early finds between the pixels under
            pressure and its active set.
        contact_pixels: of the predicted mask.
        log_load: log10 F / (E* A0 rms slope).
    """

    doubt: float
    contact_pixels: int
    log_load: float


def calibrated(evidence: Sequence[Evidence], errors: Mapping[str, Sequence[float]]) -> Calibration:
    """Fit the errors found on held-out surfaces.

    Args:
        evidence: of the predictions.
        errors: for each of ``QUANTITIES`` what the predictions were wrong by.
    """
    design = np.array([_predictors(one) for one in evidence])
    found: Calibration = {}
    for quantity in QUANTITIES:
        error = np.asarray(errors[quantity])
        powers = _poisson(design, error)
        factor = np.quantile(error / np.exp(design @ powers), COVERED)
        found[quantity] = {"powers": powers.tolist(), "factor": float(factor)}
    return found


def error_bars(evidence: Evidence, calibration: Calibration) -> dict[str, ErrorBar]:
    """The error to expect of each quantity; at most one, which is all that Dice can lose."""
    predictors = _predictors(evidence)
    bars = {}
    for quantity in QUANTITIES:
        expected = min(float(np.exp(predictors @ np.asarray(calibration[quantity]["powers"]))), 1.0)
        bars[quantity] = ErrorBar(expected, min(expected * float(calibration[quantity]["factor"]), 1.0))
    return bars


def _poisson(design: FloatArray, error: FloatArray) -> FloatArray:
    """Powers of the mean by Poisson regression, which bears errors of exactly zero and leaves the overall mean right."""

    def deviance(powers: FloatArray) -> tuple[float, FloatArray]:
        logarithm = design @ powers
        mean = np.exp(np.minimum(logarithm, LARGEST_LOG))
        return float((mean - error * logarithm).mean()), design.T @ (mean - error) / len(error)

    start = np.zeros(design.shape[1])
    start[0] = np.log(max(error.mean(), LEAST))
    powers: FloatArray = minimize(deviance, start, jac=True, method="BFGS").x
    return powers


def _predictors(evidence: Evidence) -> FloatArray:
    return np.array([1.0, np.log(max(evidence.doubt, LEAST)), np.log(max(evidence.contact_pixels, 1)), evidence.log_load])
