import numpy as np
import pytest

from solver.convolution import convolution
from solver.multilevel import Multilevel

SHAPES = [(4, 4), (8, 9), (24, 25), (30, 41), (64, 64), (7, 513), (300, 24), (131, 256)]


def relative_error(shape: tuple[int, int], aspect: float, pressure: np.ndarray, **kind: object) -> float:
    """Largest error against the exact convolution, relative to the largest displacement."""
    exact = convolution("free", shape, (aspect, 1.0))(pressure)
    approximate = Multilevel(shape, (aspect, 1.0), **kind)(pressure.astype(kind.get("precision", "float64")))  # type: ignore[arg-type, call-overload]
    return float(np.abs(approximate - exact).max() / np.abs(exact).max())


def spots(shape: tuple[int, int]) -> np.ndarray:
    """Pressures on a few scattered pixels."""
    generator = np.random.default_rng(0)
    return generator.random(shape) * (generator.random(shape) < 0.1)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("aspect", [1.0, 2.5, 1 / 20])
def test_the_displacement_is_that_of_the_exact_convolution(shape: tuple[int, int], aspect: float) -> None:
    assert relative_error(shape, aspect, spots(shape) + 1e-12) < 5e-7


@pytest.mark.parametrize("aspect", [1000.0, 1 / 1000])
def test_pixels_may_be_very_long(aspect: float) -> None:
    assert relative_error((100, 60), aspect, spots((100, 60)) + 1e-12) < 5e-7


@pytest.mark.parametrize(
    ("order", "tile", "precision", "spot_error", "noise_error"),
    [
        (4, 6, "float64", 5e-6, 2e-5),
        (4, 8, "float64", 1.5e-6, 5e-6),
        (6, 8, "float64", 2e-7, 5e-7),
        (8, 14, "float64", 3e-10, 5e-10),
        (6, 8, "float32", 2e-6, 2e-6),
    ],
)
def test_the_error_falls_with_the_order_of_the_transfer_and_the_reach_of_the_stencil(
    order: int, tile: int, precision: str, spot_error: float, noise_error: float
) -> None:
    """The documented bounds; noise, without the smooth part that dominates contact, is the hardest pressure."""
    kind = {"order": order, "tile": tile, "precision": precision}
    noise = np.random.default_rng(1).standard_normal((128, 128))
    assert relative_error((128, 128), 1.0, spots((128, 128)), **kind) < spot_error
    assert relative_error((128, 128), 1.0, noise, **kind) < noise_error


def test_the_operator_is_symmetric() -> None:
    multilevel = Multilevel((70, 50), (1.3, 1.0))
    p, q = np.random.default_rng(2).random((2, 70, 50))
    assert np.vdot(p, multilevel(q)) == pytest.approx(np.vdot(q, multilevel(p)), rel=1e-12)


def test_a_batch_is_its_surfaces_one_by_one() -> None:
    multilevel = Multilevel((70, 50), (1.0, 1.0))
    batch = np.stack([spots((70, 50)), np.zeros((70, 50)), np.random.default_rng(3).random((70, 50))])
    for one, displaced in zip(batch, multilevel(batch), strict=True):
        np.testing.assert_allclose(displaced, multilevel(one), atol=1e-12 * np.abs(displaced).max())


def test_between_some_pixels_it_is_the_whole_operator() -> None:
    """Surfaces with fewer pixels than others are filled up with places past the end."""
    multilevel = Multilevel((70, 50), (1.0, 1.0))
    batch = np.stack([spots((70, 50)), spots((70, 50))[::-1]])
    batch[1, :40] = 0
    counts = np.count_nonzero(batch, axis=(1, 2))
    real = np.arange(counts.max()) < counts[:, np.newaxis]
    places = np.full(real.shape, batch.size)
    places[real] = np.flatnonzero(batch)
    values = np.where(real, np.append(batch.ravel(), 99.0)[places], 99.0)
    np.testing.assert_allclose(multilevel.between(places)(values)[real], multilevel(batch).ravel()[places[real]], rtol=1e-12)
    assert counts[0] > counts[1] > 0


@pytest.mark.parametrize("place", [(0, 0), (3, 250), (100, 131)])
def test_one_pixel_under_pressure(place: tuple[int, int]) -> None:
    pressure = np.zeros((256, 255))
    pressure[place] = 1
    assert relative_error(pressure.shape, 1.0, pressure) < 5e-7
    places = np.ravel_multi_index(place, pressure.shape) * np.ones((1, 1), dtype=np.intp)
    alone = Multilevel(pressure.shape, (1.0, 1.0)).between(places)(np.ones((1, 1)))
    exact = convolution("free", pressure.shape, (1.0, 1.0))(pressure)[place]
    assert float(alone[0, 0]) == pytest.approx(float(exact), rel=1e-6)


@pytest.mark.parametrize("order", [4, 6])
def test_the_error_does_not_grow_with_the_number_of_levels(order: int) -> None:
    errors = [relative_error((size, size), 1.0, spots((size, size)), order=order) for size in (64, 512)]
    assert errors[1] < 3 * errors[0]
