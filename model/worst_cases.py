"""The maps on which a prediction is worst, and where it is wrong there."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import binary_dilation, binary_erosion

from model.held_out import HeldOutSet
from model.outcome import Outcome
from solver.contact_statistics import contact_spots

WORST = 3

Judged = tuple[HeldOutSet, Outcome]


def worst_cases(found: Sequence[tuple[HeldOutSet, Sequence[Outcome]]]) -> list[Judged]:
    """The maps with the lowest Dice."""
    outcomes = [(held_out, outcome) for held_out, several in found for outcome in several]
    return sorted(outcomes, key=lambda pair: pair[1].comparison.dice)[:WORST]


def explained(cases: Sequence[Judged]) -> str:
    """As a Markdown table: how little contact there is, in how many spots, and how many of the wrong pixels edge them."""
    lines = [
        "| set | Dice | 1 - Dice expected | pixels in contact | spots | wrong pixels | at the edge of a spot "
        "| outside training |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for held_out, outcome in cases:
        reference, prediction = outcome.reference, outcome.prediction
        wrong = reference != prediction.contact_mask
        edge = binary_dilation(reference, iterations=1) & ~binary_erosion(reference, iterations=1)
        spots = int(contact_spots(reference, outcome.problem.boundary).max())
        lines.append(
            f"| {held_out.group}: {held_out.name} | {outcome.comparison.dice:.4f} | {prediction.expected_error.dice:.4f} "
            f"| {np.count_nonzero(reference)} | {spots} | {np.count_nonzero(wrong)} | {np.count_nonzero(wrong & edge)} "
            f"| {'; '.join(prediction.outside) or 'no'} |"
        )
    return "\n".join(lines) + "\n"
