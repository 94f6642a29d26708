"""The contact as the network says it, and how far it disagrees with the mechanics."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from model.mask import active, decide
from model.metrics import dice
from solver.gap import gap_under
from solver.problem import BoolArray, ContactProblem, FloatArray


@dataclass(frozen=True, eq=False)
class Contact:
    """What the network says of a problem; fields of shape (rows, columns).

    Attributes:
        problem: what touches.
        probability: of contact, float32.
        mask: where it is more likely than not.
        pressure: in Pa, zero off the mask; it carries the load.
    """

    problem: ContactProblem
    probability: NDArray[np.float32]
    mask: BoolArray
    pressure: FloatArray

    @classmethod
    def of(cls, problem: ContactProblem, logits: Tensor, relative: Tensor) -> "Contact":
        """From the logits of contact and the relative pressures, shape (rows, columns)."""
        probability: NDArray[np.float32] = torch.sigmoid(logits).numpy()
        mask = decide(probability)
        touching = np.maximum(probability[mask] * relative.numpy()[mask], np.finfo(np.float32).tiny).astype(np.float64)
        pressure = np.zeros(problem.shape)
        pressure[mask] = touching * (problem.load / problem.pixel_area / touching.sum())
        return cls(problem, probability, mask, pressure)

    def disagreement(self) -> float:
        """1 - Dice between the mask and where the bodies would touch by the gap that the pressure leaves.

        It needs no network to be right: where the network errs, the bodies overlap off the mask, or part on it.
        """
        return 1 - dice(active(self.problem, self.pressure, gap_under(self.problem, self.pressure)), self.mask)
