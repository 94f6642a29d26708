"""What an evaluation finds on one map, and on all maps of a set."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.held_out import HeldOutSet
from model.metrics import Comparison, compare
from model.prediction import Prediction
from solver.problem import BoolArray, ContactProblem
from solver.resistance import boyer_resistance


@dataclass(frozen=True, eq=False)
class Outcome:
    """A prediction beside its reference.

    Attributes:
        problem: of the map.
        reference: contact mask of the solver.
        prediction: what is judged.
        milliseconds: that it took.
        comparison: of the masks.
        resistances: of the prediction and of the reference by Boyer's formula, in units of the resistivity, 1/m.
    """

    problem: ContactProblem
    reference: BoolArray
    prediction: Prediction
    milliseconds: float
    comparison: Comparison
    resistances: tuple[float, float]

    @classmethod
    def of(cls, problem: ContactProblem, reference: BoolArray, prediction: Prediction, milliseconds: float) -> "Outcome":
        """Compare."""
        masks = prediction.contact_mask, reference
        ours, theirs = (boyer_resistance(mask, problem.pixel_size, 1.0) for mask in masks)
        return cls(problem, reference, prediction, milliseconds, compare(reference, masks[0]), (ours, theirs))

    @property
    def errors(self) -> tuple[float, float, float]:
        """1 - Dice and the relative errors of area and resistance, as in ``calibration.QUANTITIES``."""
        ours, theirs = self.resistances
        return 1 - self.comparison.dice, abs(self.comparison.area_error), abs(ours / theirs - 1)


@dataclass(frozen=True)
class Row:
    """Agreement with the reference over the maps of one set; errors of area and resistance are relative.

    Attributes:
        area_bias: mean of the error of the area with its sign.
        expected: mean of 1 - Dice as the predictions expected it; ``covered``: share of those within their bounds.
        methods: how often each way to answer was taken.
    """

    group: str
    name: str
    paper: float | None
    maps: int
    dice: float
    dice_5th_percentile: float
    jaccard: float
    bf_score: float
    pixel_accuracy: float
    area_error: float
    area_bias: float
    resistance_error: float
    expected: float
    covered: float
    milliseconds: float
    methods: dict[str, int]

    @classmethod
    def of(cls, held_out: HeldOutSet, outcomes: Sequence[Outcome]) -> "Row":
        """The means over a set."""
        comparisons = [outcome.comparison for outcome in outcomes]
        expected = [outcome.prediction.expected_error for outcome in outcomes]
        errors = np.array([outcome.errors for outcome in outcomes])
        return cls(
            group=held_out.group,
            name=held_out.name,
            paper=held_out.paper,
            maps=len(outcomes),
            dice=1 - float(errors[:, 0].mean()),
            dice_5th_percentile=1 - float(np.percentile(errors[:, 0], 95)),
            jaccard=float(np.mean([comparison.jaccard for comparison in comparisons])),
            bf_score=float(np.mean([comparison.bf_score for comparison in comparisons])),
            pixel_accuracy=float(np.mean([comparison.pixel_accuracy for comparison in comparisons])),
            area_error=float(errors[:, 1].mean()),
            area_bias=float(np.mean([comparison.area_error for comparison in comparisons])),
            resistance_error=float(errors[:, 2].mean()),
            expected=float(np.mean([one.dice for one in expected])),
            covered=float(np.mean([error <= one.dice_bound for error, one in zip(errors[:, 0], expected, strict=True)])),
            milliseconds=float(np.median([outcome.milliseconds for outcome in outcomes])),
            methods=dict(Counter(outcome.prediction.method for outcome in outcomes)),
        )
