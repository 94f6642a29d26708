from dataclasses import replace

import numpy as np

from benchmarks.cases import midpoint_problem
from model import Surrogate
from model.dataset import DatasetConfig
from model.held_out import HeldOutSet
from model.outcome import Outcome
from model.worst_cases import explained, worst_cases
from solver import solve

SET = HeldOutSet("by scale", "64 x 64", DatasetConfig(size=64))


def outcome(seed: int, shift: int) -> Outcome:
    """A reference beside itself, rolled by some pixels."""
    problem = midpoint_problem(64, 30.0, seed=seed)
    reference = solve(problem).contact_mask
    prediction = replace(Surrogate.load().estimate(problem), contact_mask=np.roll(reference, shift, axis=1))
    return Outcome.of(problem, reference, prediction, 1.0)


def test_the_lowest_dice_come_first_and_their_wrong_pixels_are_counted() -> None:
    outcomes = [outcome(seed, shift) for seed, shift in enumerate((0, 9, 1, 20, 2))]
    cases = worst_cases([(SET, outcomes)])
    assert {id(one) for _, one in cases} <= {id(outcomes[i]) for i in (1, 2, 3, 4)}
    assert cases[0][1].comparison.dice == min(one.comparison.dice for one in outcomes)

    row = explained([(SET, outcomes[2])]).splitlines()[-1].split("|")
    reference, predicted = outcomes[2].reference, outcomes[2].prediction.contact_mask
    assert int(row[4]) == reference.sum()
    assert int(row[6]) == (reference != predicted).sum()
    assert int(row[7]) == int(row[6]), "rolled by one pixel, it is wrong at edges alone"
