import numpy as np
import pytest

from benchmarks.certificates import love
from solver.convolution import convolution

SHAPES = [(4, 4), (7, 12), (16, 5), (31, 32)]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("pixel_size", [(1.0, 1.0), (0.5, 3.0)])
def test_free_boundary_equals_the_direct_sum(shape: tuple[int, int], pixel_size: tuple[float, float]) -> None:
    pressure = np.random.default_rng(0).random(shape)
    rows, columns = shape
    coefficients = love(pixel_size, (rows, columns))
    direct = np.zeros(shape)
    for i in range(rows):
        for j in range(columns):
            direct += pressure[i, j] * coefficients[rows - 1 - i : 2 * rows - 1 - i, columns - 1 - j : 2 * columns - 1 - j]
    scale = np.sqrt(pixel_size[0] * pixel_size[1])
    np.testing.assert_allclose(convolution("free", shape, pixel_size)(pressure) * scale, direct, rtol=1e-12)


@pytest.mark.parametrize(("along_rows", "along_columns"), [(1, 0), (0, 3), (2, 5)])
def test_periodic_boundary_has_plane_waves_as_eigenfunctions(along_rows: int, along_columns: int) -> None:
    """A pressure wave of wave number q displaces by 2 / (E* q) (Johnson 1985, section 13.2)."""
    rows, columns, dy, dx = 24, 32, 0.5, 2.0
    qy, qx = 2 * np.pi * along_rows / (rows * dy), 2 * np.pi * along_columns / (columns * dx)
    y, x = np.meshgrid(np.arange(rows) * dy, np.arange(columns) * dx, indexing="ij")
    wave = np.cos(qy * y + qx * x)
    displacement = convolution("periodic", (rows, columns), (dy, dx))(1 + wave)
    np.testing.assert_allclose(displacement * np.sqrt(dy * dx), 2 / np.hypot(qy, qx) * wave, atol=1e-12)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_operator_is_symmetric(boundary: str) -> None:
    generator = np.random.default_rng(1)
    convolve = convolution(boundary, (13, 20), (1.0, 1.7))  # type: ignore[arg-type]
    p, q = generator.random((2, 13, 20))
    assert np.vdot(p, convolve(q)) == pytest.approx(np.vdot(q, convolve(p)), rel=1e-12)
