import numpy as np
import pytest

from model.calibration import QUANTITIES, Evidence, calibrated, error_bars


def made_up(count: int, seed: int) -> tuple[list[Evidence], dict[str, list[float]]]:
    """Errors that follow a power law of the doubt, larger where few pixels touch, with scatter."""
    generator = np.random.default_rng(seed)
    evidence = [
        Evidence(float(doubt), int(pixels))
        for doubt, pixels in zip(10 ** generator.uniform(-3, -1, count), 10 ** generator.uniform(1, 4, count), strict=True)
    ]
    errors = {
        quantity: [scale * one.doubt**0.8 * np.exp(one.contact_pixels**-0.5 + 0.4 * generator.normal()) for one in evidence]
        for quantity, scale in zip(QUANTITIES, (1.0, 0.5, 0.2), strict=True)
    }
    return evidence, errors


def test_means_and_bounds_hold_on_others() -> None:
    calibration = calibrated(*made_up(2000, seed=0))
    evidence, errors = made_up(2000, seed=1)
    for quantity in QUANTITIES:
        bars = [error_bars(one, calibration)[quantity] for one in evidence]
        found = np.array(errors[quantity])
        assert np.mean([bar.expected for bar in bars]) == pytest.approx(found.mean(), rel=0.05)
        assert np.mean(found <= [bar.bound for bar in bars]) == pytest.approx(0.9, abs=0.03)
        assert np.corrcoef([bar.expected for bar in bars], found)[0, 1] > 0.8


def test_no_error_is_expected_to_exceed_one() -> None:
    calibration = calibrated(*made_up(200, seed=0))
    for bar in error_bars(Evidence(1.0, 1), calibration).values():
        assert 0 < bar.expected <= bar.bound <= 1


def test_a_prediction_without_doubt_and_without_contact_has_error_bars() -> None:
    calibration = calibrated(*made_up(200, seed=0))
    for bar in error_bars(Evidence(0.0, 0), calibration).values():
        assert np.isfinite([bar.expected, bar.bound]).all()
