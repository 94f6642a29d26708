"""What is done to heights before they are pressed."""

import numpy as np
import pytest

from app.preparation import Detrend, composite, detrended, filled, resampled

Y, X = np.meshgrid(np.linspace(-1, 1, 40), np.linspace(-1, 1, 60), indexing="ij")
ROUGH = np.random.default_rng(1).standard_normal((40, 60)) * 1e-6


def test_a_missing_pixel_takes_the_nearest_height() -> None:
    heights = ROUGH.copy()
    heights[0, :2] = np.nan
    heights[20:30, 20:30] = np.nan
    result = filled(heights)
    known = ~np.isnan(heights)
    np.testing.assert_array_equal(result[known], heights[known])
    assert result[0, 0] in (heights[0, 2], heights[1, 0])
    assert result[20, 25] == heights[19, 25]


def test_nothing_missing_nothing_changed() -> None:
    assert filled(ROUGH) is ROUGH


@pytest.mark.parametrize(
    ("detrend", "trend"),
    [
        ("mean", np.full_like(X, 3e-6)),
        ("plane", 2e-6 - 5e-6 * X + 1e-5 * Y),
        ("curvature", 1e-6 + 3e-6 * X**2 - 2e-6 * X * Y + 8e-6 * Y**2 + 1e-6 * X),
    ],
)
def test_a_trend_is_taken_out_and_nothing_else(detrend: Detrend, trend: np.ndarray) -> None:
    bare = detrended(ROUGH, detrend)
    np.testing.assert_allclose(detrended(ROUGH + trend, detrend), bare, atol=1e-17)
    np.testing.assert_allclose(detrended(trend, detrend), 0, atol=1e-17)
    assert bare.std() == pytest.approx(ROUGH.std(), rel=0.01)


def test_a_plane_is_no_curvature() -> None:
    bowl = 5e-6 * (X**2 + Y**2)
    assert np.ptp(detrended(bowl, "plane")) == pytest.approx(np.ptp(bowl))


def test_resampling_keeps_what_both_grids_can_hold() -> None:
    waves = np.sin(3 * X + 1) * np.cos(2 * Y)
    finer = resampled(waves, (80, 120))
    assert finer.shape == (80, 120)
    np.testing.assert_allclose(finer.reshape(40, 2, 60, 2).mean((1, 3))[2:-2, 2:-2], waves[2:-2, 2:-2], atol=2e-3)
    coarser = resampled(waves, (20, 30))
    np.testing.assert_allclose(coarser[1:-1, 1:-1], waves.reshape(20, 2, 30, 2).mean((1, 3))[1:-1, 1:-1], atol=1e-2)


def test_two_surfaces_add_up_mirrored() -> None:
    assert composite(ROUGH, ROUGH)[3, 0] == ROUGH[3, 0] + ROUGH[3, -1]
