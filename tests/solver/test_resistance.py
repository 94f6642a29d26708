import numpy as np
import pytest

from solver import InvalidProblemError, boyer_resistance
from solver.errors import InvalidMaterialError


def written_as_it_reads(mask: np.ndarray, pixel_size: tuple[float, float], resistivity: float) -> float:
    """The paper's Eq. 26, pair by pair."""
    at = np.argwhere(mask) * np.array(pixel_size)
    distances = np.hypot(*(at[:, np.newaxis, :] - at[np.newaxis, :, :]).transpose(2, 0, 1))
    count = len(at)
    pairs = (1 / distances[~np.eye(count, dtype=bool)]).sum()
    side = np.sqrt(pixel_size[0] * pixel_size[1])
    return resistivity * (0.868 / (count * side) + pairs / (np.pi * count**2))


@pytest.mark.parametrize("shape", [(16, 16), (7, 30)])
@pytest.mark.parametrize("pixel_size", [(1e-6, 1e-6), (1e-6, 3e-6)])
def test_the_autocorrelation_gives_the_double_sum(shape: tuple[int, int], pixel_size: tuple[float, float]) -> None:
    mask = np.random.default_rng(0).random(shape) < 0.3
    expected = written_as_it_reads(mask, pixel_size, 1.7e-8)
    assert boyer_resistance(mask, pixel_size, 1.7e-8) == pytest.approx(expected, rel=1e-12)


def test_one_pixel_is_one_square_spot() -> None:
    mask = np.zeros((9, 9), dtype=bool)
    mask[4, 4] = True
    assert boyer_resistance(mask, (2e-6, 2e-6), 1.7e-8) == pytest.approx(0.868 * 1.7e-8 / 2e-6)


def test_a_disc_is_within_eight_percent_above_the_isothermal_disc() -> None:
    """R = rho / (2 a); equal current in every pixel overestimates, as measured, by 7 %."""
    y, x = np.mgrid[-64:64, -64:64] + 0.5
    mask = np.hypot(y, x) < 40
    radius = np.sqrt(mask.sum() / np.pi)
    assert 1.0 < boyer_resistance(mask, (1.0, 1.0), 1.0) * 2 * radius < 1.08


def test_no_contact_and_bad_resistivity_are_refused() -> None:
    mask = np.zeros((8, 8), dtype=bool)
    with pytest.raises(InvalidProblemError, match="infinite"):
        boyer_resistance(mask, (1.0, 1.0), 1.0)
    mask[0, 0] = True
    for resistivity in (0.0, -1.0, np.nan):
        with pytest.raises(InvalidMaterialError):
            boyer_resistance(mask, (1.0, 1.0), resistivity)
