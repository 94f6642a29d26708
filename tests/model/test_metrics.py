import numpy as np
import pytest

from model import compare
from model.metrics import bf_score


def square(row: int, column: int, side: int) -> np.ndarray:
    mask = np.zeros((40, 40), dtype=bool)
    mask[row : row + side, column : column + side] = True
    return mask


def test_a_mask_compared_with_itself() -> None:
    mask = square(10, 10, 12)
    comparison = compare(mask, mask)
    assert (comparison.dice, comparison.jaccard, comparison.bf_score, comparison.pixel_accuracy) == (1, 1, 1, 1)
    assert comparison.area_error == 0


def test_counts_by_hand() -> None:
    """10 x 10 against the same moved by 5 columns: TP = 50, FP = FN = 50."""
    comparison = compare(square(10, 10, 10), square(10, 15, 10))
    assert comparison.dice == pytest.approx(0.5)
    assert comparison.jaccard == pytest.approx(1 / 3)
    assert comparison.pixel_accuracy == pytest.approx(1 - 100 / 1600)
    assert comparison.area_error == 0


def test_area_error_has_the_sign_of_the_prediction() -> None:
    assert compare(square(10, 10, 10), square(10, 10, 5)).area_error == pytest.approx(-0.75)


@pytest.mark.parametrize(("shift", "all_matched"), [(0, True), (1, True), (2, True), (3, False)])
def test_boundaries_match_within_two_pixels(shift: int, all_matched: bool) -> None:
    assert (bf_score(square(10, 10, 12), square(10 + shift, 10, 12)) == 1) is all_matched


def test_boundaries_match_by_euclidean_distance() -> None:
    """Two pixels away along both directions is farther than two pixels."""
    pixel, diagonal = square(10, 10, 1), square(12, 12, 1)
    assert bf_score(pixel, diagonal) == 0
    assert bf_score(pixel, diagonal, tolerance=3) == 1


def test_the_boundary_score_is_not_dice() -> None:
    """As printed, the paper's Eqs. 19-21 give Dice; a wrong interior does not move a boundary."""
    thick, thin = square(5, 5, 30), square(5, 5, 30)
    thin[15:25, 15:25] = False
    comparison = compare(thick, thin)
    assert comparison.dice > 0.9
    assert comparison.bf_score < comparison.dice


def test_an_empty_prediction_scores_nothing() -> None:
    comparison = compare(square(3, 3, 4), np.zeros((40, 40), dtype=bool))
    assert (comparison.dice, comparison.jaccard, comparison.bf_score) == (0, 0, 0)
    assert comparison.area_error == -1


def test_full_contact_compares_with_full_contact() -> None:
    full = np.ones((8, 8), dtype=bool)
    assert compare(full, full).bf_score == 1
