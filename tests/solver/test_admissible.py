import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from solver.admissible import balanced, projected, within

seeds = st.integers(0, 10_000)


@given(seed=seeds, share=st.floats(0.02, 0.98))
def test_projected_pressures_are_admissible(seed: int, share: float) -> None:
    generator = np.random.default_rng(seed)
    trial, weights = generator.standard_normal((3, 20)), generator.random((3, 20)) + 0.01
    cap = generator.random(3) + 0.1
    load = share * 20 * cap
    for highest in (None, cap):
        pressure = projected(trial, load, highest, weights)
        assert (pressure >= 0).all()
        np.testing.assert_allclose(pressure.sum(axis=1), load, rtol=1e-9)
        if highest is not None:
            assert (pressure <= cap[:, np.newaxis]).all()


def test_with_equal_weights_the_projection_is_the_nearest_admissible_pressure() -> None:
    trial = np.random.default_rng(1).standard_normal((1, 6))
    load, cap = np.array([2.0]), np.array([0.7])
    for highest in (None, cap):
        found = minimize(
            lambda p: ((p - trial[0]) ** 2).sum(),
            np.full(6, 2.0 / 6),
            bounds=[(0, None if highest is None else 0.7)] * 6,
            constraints={"type": "eq", "fun": lambda p: p.sum() - 2.0},
            tol=1e-12,
        )
        np.testing.assert_allclose(projected(trial, load, highest, np.ones((1, 6)))[0], found.x, atol=1e-6)


def test_balancing_leaves_what_flows_and_scales_the_rest() -> None:
    pressure, cap = np.array([[1.0, 0.5, 0.25, 0.0]]), np.array([1.0])
    np.testing.assert_allclose(balanced(pressure, np.array([1.6]), cap), [[1.0, 0.4, 0.2, 0.0]])
    np.testing.assert_allclose(balanced(pressure, np.array([3.5]), None), [[2.0, 1.0, 0.5, 0.0]])


def test_pressures_are_cut_off_at_both_bounds() -> None:
    np.testing.assert_array_equal(within(np.array([[-1.0, 0.5, 3.0]]), np.array([2.0])), np.array([[0.0, 0.5, 2.0]]))
