import numpy as np
import pytest

from solver.convolution import convolution
from solver.full_contact import full_contact_filter
from solver.problem import Boundary

ROWS, COLUMNS = 24, 30


@pytest.mark.parametrize("aspect", [1.0, 4.0, 0.1])
def test_on_a_periodic_surface_it_inverts_the_displacement(aspect: float) -> None:
    pressure = np.random.default_rng(0).standard_normal((ROWS, COLUMNS))
    pressure -= pressure.mean()
    displacement = convolution("periodic", (ROWS, COLUMNS), (aspect, 1.0))(pressure)
    inverse = full_contact_filter("periodic", (ROWS, COLUMNS), (aspect, 1.0))
    np.testing.assert_allclose(inverse(displacement), pressure, atol=1e-12)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("aspect", [1.0, 4.0, 0.1])
def test_it_is_symmetric_and_positive_definite(boundary: Boundary, aspect: float) -> None:
    identity = np.eye(ROWS * COLUMNS).reshape(-1, ROWS, COLUMNS)
    matrix = full_contact_filter(boundary, (ROWS, COLUMNS), (aspect, 1.0))(identity).reshape(ROWS * COLUMNS, -1)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-6)
    assert np.linalg.eigvalsh((matrix + matrix.T) / 2).min() > 0


def test_on_an_isolated_patch_it_is_close_to_the_inverse() -> None:
    """The eigenvalues of filter times displacement lie within a small factor, those of displacement alone do not."""
    identity = np.eye(ROWS * COLUMNS).reshape(-1, ROWS, COLUMNS)
    displacement = convolution("free", (ROWS, COLUMNS), (1.0, 1.0))(identity).reshape(ROWS * COLUMNS, -1)
    inverse = full_contact_filter("free", (ROWS, COLUMNS), (1.0, 1.0))(identity).reshape(ROWS * COLUMNS, -1)
    eigenvalues = np.linalg.eigvals(inverse @ displacement).real
    alone = np.linalg.eigvalsh(displacement)
    assert eigenvalues.max() / eigenvalues.min() < 5
    assert alone.max() / alone.min() > 40
