import numpy as np
import pytest

from benchmarks.cases import midpoint_problem
from model.mask import active, decide, doubt
from model.metrics import compare
from solver import solve


def test_contact_is_where_it_is_more_likely_than_not_but_a_load_always_touches_somewhere() -> None:
    probability = np.array([[0.1, 0.6], [0.4, 0.2]], dtype=np.float32)
    np.testing.assert_array_equal(decide(probability), [[False, True], [False, False]])
    np.testing.assert_array_equal(decide(probability / 10), [[False, True], [False, False]])


def test_doubt_is_the_dice_lost_on_average() -> None:
    rng = np.random.default_rng(0)
    probability = rng.random((40, 40)).astype(np.float32) ** 3
    mask = decide(probability)
    lost = [1 - compare(rng.random((40, 40)) < probability, mask).dice for _ in range(300)]
    assert doubt(probability, mask) == pytest.approx(np.mean(lost), rel=0.01)
    assert doubt(mask.astype(np.float32), mask) == 0


def test_a_solve_that_stopped_early_tells_where_the_bodies_will_touch() -> None:
    stopped_errors, active_errors, stopped_dice, active_dice = [], [], [], []
    for seed in range(6):
        problem = midpoint_problem(128, 30.0, seed=seed)
        reference, stopped = solve(problem), solve(problem, tolerance=1e-2)
        solution = solve(problem, tolerance=1e-10)
        np.testing.assert_array_equal(active(problem, solution.pressure, solution.gap), reference.contact_mask)
        by_pressure = compare(reference.contact_mask, stopped.contact_mask)
        by_both = compare(reference.contact_mask, active(problem, stopped.pressure, stopped.gap))
        stopped_errors.append(by_pressure.area_error)
        active_errors.append(by_both.area_error)
        stopped_dice.append(by_pressure.dice)
        active_dice.append(by_both.dice)
    assert abs(np.mean(active_errors)) < abs(np.mean(stopped_errors)) / 2
    assert np.mean(active_dice) > np.mean(stopped_dice)
