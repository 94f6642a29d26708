import numpy as np
import pytest

from solver.candidates import Candidates, stencil
from solver.convolution import Precision, convolution

ASPECTS = [1.0, 3.0, 1 / 3, 20.0, 1 / 20, 200.0]
SHAPE = (12, 13)


def some(aspect: float, share: float = 0.6, precision: Precision = "float64") -> tuple[np.ndarray, Candidates]:
    mask = np.random.default_rng(0).random(SHAPE) < share
    return mask, Candidates(mask, (aspect, 1.0), convolution("free", SHAPE, (aspect, 1.0), precision))


def test_fields_are_gathered_and_scattered() -> None:
    mask, candidates = some(1.0)
    field = np.random.default_rng(1).random(SHAPE)
    np.testing.assert_array_equal(candidates.scatter(candidates.gather(field)), np.where(mask, field, 0))


@pytest.mark.parametrize(("precision", "error"), [("float64", 1e-13), ("float32", 1e-6)])
@pytest.mark.parametrize("size", [1.0, 1e-40, 1e30])
def test_displacements_are_those_of_the_whole_grid(precision: Precision, error: float, size: float) -> None:
    """Also for pressures that single precision could not hold."""
    _, candidates = some(3.0, precision=precision)
    values = np.random.default_rng(2).standard_normal(candidates.indices.size)
    whole = convolution("free", SHAPE, (3.0, 1.0))(candidates.scatter(values))
    np.testing.assert_allclose(candidates.convolve(values * size) / size, candidates.gather(whole), rtol=error, atol=error)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_the_preconditioner_is_symmetric_and_positive_definite_on_any_working_set(aspect: float) -> None:
    _, candidates = some(aspect)
    count = candidates.indices.size
    working = np.random.default_rng(3).random(count) < 0.7
    columns = np.stack([candidates.precondition(unit, working.astype(float))[working] for unit in np.eye(count)[working]])
    np.testing.assert_allclose(columns, columns.T, atol=1e-14)
    assert np.linalg.eigvalsh(columns).min() > 0


@pytest.mark.parametrize("aspect", ASPECTS)
def test_the_preconditioner_nearly_inverts_the_displacement(aspect: float) -> None:
    """The spectrum of preconditioner times operator on the whole grid spans less than a fifth of the operator's own."""
    _, candidates = some(aspect, share=1.1)
    everywhere = np.ones(candidates.indices.size)
    operator = np.stack([candidates.convolve(unit) for unit in np.eye(everywhere.size)])
    product = np.stack([candidates.precondition(column, everywhere) for column in operator])
    plain, preconditioned = (np.sort(np.linalg.eigvals(matrix).real) for matrix in (operator, product))
    assert preconditioned[-1] / preconditioned[0] < 0.2 * plain[-1] / plain[0]


def test_the_stencil_of_square_pixels() -> None:
    assert stencil((1.0, 1.0)) == pytest.approx((1.163, -0.183, -0.183, -0.048), abs=5e-4)
