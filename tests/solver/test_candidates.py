import numpy as np
import pytest

from solver.candidates import Candidates, stencil
from solver.convolution import Precision, convolution

ASPECTS = [1.0, 3.0, 1 / 3, 20.0, 1 / 20, 200.0]
SHAPE = (12, 13)


def some(aspect: float, share: float = 0.6, precision: Precision = "float64") -> tuple[np.ndarray, Candidates]:
    """Candidates on two surfaces, more of them on the second."""
    mask = np.random.default_rng(0).random((2, *SHAPE)) < [[[share]], [[1.3 * share]]]
    return mask, Candidates(mask, (aspect, 1.0), convolution("free", SHAPE, (aspect, 1.0), precision))


def count(mask: np.ndarray) -> int:
    return int(mask.sum(axis=(1, 2)).max())


def test_fields_are_gathered_and_scattered() -> None:
    mask, candidates = some(1.0)
    field = np.random.default_rng(1).random(mask.shape)
    gathered = candidates.gather(field, fill=7.0)
    np.testing.assert_array_equal(candidates.scatter(gathered), np.where(mask, field, 0))
    filled = count(mask) - mask.sum(axis=(1, 2))
    np.testing.assert_array_equal((gathered == 7.0).sum(axis=1), filled)
    assert filled.max() > 0


@pytest.mark.parametrize(("precision", "error"), [("float64", 1e-13), ("float32", 1e-6)])
@pytest.mark.parametrize("size", [1.0, 1e-40, 1e30])
def test_displacements_are_those_of_the_whole_grid(precision: Precision, error: float, size: float) -> None:
    """Also for pressures that single precision could not hold."""
    mask, candidates = some(3.0, precision=precision)
    field = np.where(mask, np.random.default_rng(2).standard_normal(mask.shape), 0)
    whole = convolution("free", SHAPE, (3.0, 1.0))(field)
    displaced = candidates.convolve(candidates.gather(field * size, 0.0), np.full(2, size)) / size
    np.testing.assert_allclose(candidates.scatter(displaced)[mask], whole[mask], rtol=error, atol=error)


def preconditioner(mask: np.ndarray, candidates: Candidates, share: float) -> np.ndarray:
    """The matrix of the preconditioner on a random working set of the second surface."""
    working = np.random.default_rng(3).random((2, count(mask))) < [[0.0], [share]]
    units = [np.stack([np.zeros_like(unit), unit]) for unit in np.eye(count(mask))[working[1]]]
    return np.stack([candidates.precondition(unit, working.astype(float))[working] for unit in units])


@pytest.mark.parametrize("aspect", ASPECTS)
def test_the_preconditioner_is_symmetric_and_positive_definite_on_any_working_set(aspect: float) -> None:
    matrix = preconditioner(*some(aspect), share=0.7)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-14)
    assert np.linalg.eigvalsh(matrix).min() > 0


@pytest.mark.parametrize("aspect", ASPECTS)
def test_the_preconditioner_nearly_inverts_the_displacement(aspect: float) -> None:
    """The spectrum of preconditioner times operator on the whole grid spans less than a fifth of the operator's own."""
    mask, candidates = some(aspect, share=1.1)
    size = count(mask)
    both = [np.stack([unit, unit]) for unit in np.eye(size)]
    operator = np.stack([candidates.convolve(unit, np.ones(2))[0] for unit in both])
    product = operator @ preconditioner(mask, candidates, share=1.1)
    plain, preconditioned = (np.sort(np.linalg.eigvals(matrix).real) for matrix in (operator, product))
    assert preconditioned[-1] / preconditioned[0] < 0.2 * plain[-1] / plain[0]


def test_the_stencil_of_square_pixels() -> None:
    assert stencil((1.0, 1.0)) == pytest.approx((1.163, -0.183, -0.183, -0.048), abs=5e-4)
