import numpy as np
import pytest

from solver.convolution import convolution
from solver.preconditioner import Preconditioner

ASPECTS = [1.0, 3.0, 1 / 3, 20.0, 1 / 20, 200.0]


@pytest.mark.parametrize("aspect", ASPECTS)
def test_it_is_symmetric_and_positive_definite_on_any_contact_set(aspect: float) -> None:
    generator = np.random.default_rng(0)
    precondition = Preconditioner((aspect, 1.0))
    working = generator.random((6, 7)) < 0.7
    basis = np.eye(42)[working.ravel()].reshape(-1, 6, 7)
    columns = np.stack([precondition(field, working)[working] for field in basis])
    np.testing.assert_allclose(columns, columns.T, atol=1e-14)
    assert np.linalg.eigvalsh(columns).min() > 0


@pytest.mark.parametrize("aspect", ASPECTS)
def test_it_nearly_inverts_the_displacement(aspect: float) -> None:
    """The spectrum of preconditioner times operator on a contact set spans less than a fifth of the operator's own."""
    shape = (12, 12)
    working = np.ones(shape, dtype=bool)
    convolve, precondition = convolution("free", shape, (aspect, 1.0)), Preconditioner((aspect, 1.0))
    basis = np.eye(144).reshape(-1, *shape)
    operator = np.stack([convolve(field).ravel() for field in basis])
    product = np.stack([precondition(convolve(field), working).ravel() for field in basis])
    plain, preconditioned = (np.sort(np.linalg.eigvals(matrix).real) for matrix in (operator, product))
    assert preconditioned[-1] / preconditioned[0] < 0.2 * plain[-1] / plain[0]
