"""Other packages' contact solvers behind one call, each as its documentation says and at its best.

    pip install -e '.[dev,peers]'            # ContactMechanics, Tamaas, aspher (built from source with Eigen: libeigen3-dev)
    python -m venv .venv-slippy              # slippy needs an environment of its own
    .venv-slippy/bin/pip install --no-deps slippy==0.5.2
    .venv-slippy/bin/pip install 'numpy<2' 'scipy<1.12' 'pyfftw<0.15' numba tinydb scikit-image matplotlib dill sympy

Nothing of Asperity is imported here, so that every environment can run it.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Given:
    """A contact problem: heights in m, (dy, dx) in m, load in N, E* in Pa, boundary, and the tolerance to ask for."""

    heights: np.ndarray
    pixel_size: tuple[float, float]
    load: float
    effective_modulus: float
    boundary: str
    tolerance: float

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths of the map along rows and columns, in m."""
        rows, columns = self.heights.shape
        return rows * self.pixel_size[0], columns * self.pixel_size[1]

    @property
    def pixel_area(self) -> float:
        """In m^2."""
        return self.pixel_size[0] * self.pixel_size[1]


class NotSupportedError(Exception):
    """The package has no solver for such a problem."""


Answer = tuple[np.ndarray, bool]
"""Pressure in Pa, and whether the package says that it has converged."""


def contact_mechanics(given: Given) -> Answer:
    """ContactMechanics 1.8.3."""
    from ContactMechanics import FreeFFTElasticHalfSpace, PeriodicFFTElasticHalfSpace
    from ContactMechanics.Optimization import constrained_conjugate_gradients

    kind = FreeFFTElasticHalfSpace if given.boundary == "free" else PeriodicFFTElasticHalfSpace
    substrate = kind(given.heights.shape, given.effective_modulus, given.sides)
    result = constrained_conjugate_gradients(
        substrate,
        given.heights.copy(),
        external_force=given.load,
        pentol=given.tolerance * given.heights.std(),
        forcetol=given.tolerance,
        thermotol=given.tolerance,
        maxiter=5000,
    )
    return np.asarray(result.jac) / given.pixel_area, bool(result.success)


def tamaas(given: Given) -> Answer:
    """Tamaas 2.9.0."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, list(given.sides), list(given.heights.shape))
    model.E, model.nu = given.effective_modulus, 0
    solver = tm.PolonskyKeerRey(model, given.heights.copy(), given.tolerance)
    if given.boundary == "free":
        tm.ModelFactory.registerNonPeriodic(model, "free")
        solver.setIntegralOperator("free")
    error = solver.solve(given.load / (given.heights.size * given.pixel_area))
    return np.array(model.traction), bool(error <= given.tolerance)


def aspher_with(**mode: object) -> object:
    """aspher 0.1.3 in one of its modes."""

    def solve(given: Given) -> Answer:
        import aspher

        size = given.heights.shape[0]
        if given.heights.shape != (size, size) or given.pixel_size[0] != given.pixel_size[1]:
            raise NotSupportedError("square maps of square pixels only")
        coarsest = 32 if size % 32 == 0 else size
        periodic = given.boundary == "periodic"
        if coarsest == size and size != 32:
            raise NotSupportedError("32 x 2^k pixels a side only")
        if periodic and mode.get("backend") == "h2":
            raise NotSupportedError("H2 is for the free boundary")
        result = aspher.solve_nested(
            grid_size=size,
            gap=((given.heights.max() - given.heights) / given.sides[0]).ravel(),
            p_nominal=given.load / (given.heights.size * given.pixel_area) / given.effective_modulus,
            coarsest=coarsest,
            tol=given.tolerance,
            light_result=True,
            **(mode | ({"backend": "periodic"} if periodic else {})),
        )
        return np.asarray(result.pressure).reshape(size, size) * given.effective_modulus, bool(result.converged)

    return solve


def slippy(given: Given) -> Answer:
    """slippy 0.5.2, free boundary, with the one call of its convolution that is right."""
    import slippy

    slippy.CUDA = False
    from slippy.core import elastic_influence_matrix_spatial, plan_convolve, polonsky_and_keer

    if given.boundary != "free":
        raise NotSupportedError("free boundary only")
    rows, columns = given.heights.shape
    dy, dx = given.pixel_size
    influence = elastic_influence_matrix_spatial("zz", (2 * rows, 2 * columns), (dx, dy), given.effective_modulus / 2, 0.0)
    convolve = plan_convolve(given.heights, influence, domain=None, circular=False, fft_im=False)
    gap = given.heights.max() - given.heights
    failed, pressure, _ = polonsky_and_keer(
        convolve, np.ones_like(gap), gap, given.load, [dy, dx], eps_0=given.tolerance, max_it=5000
    )
    return np.asarray(pressure), not failed


PEERS = {
    "ContactMechanics": contact_mechanics,
    "Tamaas": tamaas,
    "aspher": aspher_with(backend="fft"),
    "slippy": slippy,
    "aspher, FFT, single": aspher_with(backend="fft", single_precision=True),
    "aspher, H2, single": aspher_with(backend="h2", active_set=True, single_precision=True),
}
