"""What an evaluation finds on one test set."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """Agreement with the reference over the maps of one test set; errors of area and resistance are relative.

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
