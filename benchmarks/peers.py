"""Time and certificate of the solver beside those of other packages, on random midpoint surfaces, in one run, one thread.

    pip install -e '.[dev,peers]'    # aspher is built from source and needs Eigen (Debian: libeigen3-dev)
    OMP_NUM_THREADS=1 python -m benchmarks.peers [SIZE ...]

Every pressure is judged by the same certificate: ours, with a fresh convolution. Operators are built anew in each solve,
as the peers do. aspher runs in its fastest modes, single precision: FFT and H2 with active set.
"""

import sys
import time
from collections.abc import Callable

import aspher
import numpy as np
import tamaas
from ContactMechanics import FreeFFTElasticHalfSpace
from ContactMechanics.Optimization import constrained_conjugate_gradients

from solver import ContactProblem, random_midpoint_displacement, solve
from solver.certificate import certify
from solver.convolution import _free_spectrum, convolution
from solver.problem import FloatArray

TOLERANCE = 1e-6
SIDE, HEIGHT, MODULUS = 1e-3, 50e-6, 6.843e9
LOADS = {"free": (30.0, 200.0, 1000.0, 1e5), "periodic": (30.0,)}
SLOW_FROM = 512
"""Pixels a side where ContactMechanics and Tamaas are run at 30 N alone; beyond it, where they take minutes, not at all."""

Solver = Callable[[ContactProblem], FloatArray]


def ours(problem: ContactProblem) -> FloatArray:
    """This package, with nothing kept from earlier solves."""
    convolution.cache_clear()
    _free_spectrum.cache_clear()
    return solve(problem, tolerance=TOLERANCE).pressure


def aspher_with(**mode: object) -> Solver:
    """aspher in a mode."""

    def run(problem: ContactProblem) -> FloatArray:
        size = problem.shape[0]
        result = aspher.solve_nested(
            grid_size=size,
            gap=(problem.initial_gap / SIDE).ravel(),
            p_nominal=problem.nominal_pressure / MODULUS,
            coarsest=32,
            tol=TOLERANCE,
            single_precision=True,
            light_result=True,
            **mode,
        )
        return np.asarray(result.pressure).reshape(size, size) * MODULUS

    return run


def contact_mechanics(problem: ContactProblem) -> FloatArray:
    """ContactMechanics, free boundary."""
    substrate = FreeFFTElasticHalfSpace(problem.shape, MODULUS, (SIDE, SIDE))
    result = constrained_conjugate_gradients(
        substrate,
        np.array(problem.heights),
        external_force=problem.load,
        pentol=TOLERANCE * problem.rms_height,
        forcetol=TOLERANCE,
        thermotol=TOLERANCE,
        maxiter=5000,
    )
    return np.asarray(result.jac) / problem.pixel_area


def tamaas_solver(problem: ContactProblem) -> FloatArray:
    """Tamaas, either boundary."""
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [SIDE, SIDE], list(problem.shape))
    model.E, model.nu = MODULUS, 0
    solver = tamaas.PolonskyKeerRey(model, np.array(problem.heights), TOLERANCE)
    if problem.boundary == "free":
        tamaas.ModelFactory.registerNonPeriodic(model, "free")
        solver.setIntegralOperator("free")
    solver.solve(problem.nominal_pressure)
    return np.array(model.traction)


def residual(problem: ContactProblem, pressure: FloatArray) -> float:
    """The certificate of a pressure."""
    scale = problem.rms_height
    unit = MODULUS * scale / np.sqrt(problem.pixel_area)
    pressure = np.maximum(pressure, 0) / unit
    displacement = convolution(problem.boundary, problem.shape, problem.pixel_size)(pressure)
    load = problem.load / (problem.pixel_area * unit)
    return certify(pressure, displacement + problem.initial_gap / scale, load).residual


def main() -> None:
    """Print a table, one case a row; seconds are the best of three, certificate in brackets."""
    tamaas.set_log_level(tamaas.LogLevel.error)
    print("| N | boundary | load N | contact | ours | aspher FFT | aspher H2 | ContactMechanics | Tamaas | aspher / ours |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for size in map(int, sys.argv[1:] or ("128", "256", "512")):
        heights = random_midpoint_displacement(size, seed=1) * HEIGHT
        for boundary, loads in LOADS.items():
            for load in loads:
                problem = ContactProblem(heights, (SIDE / size, SIDE / size), load, MODULUS, boundary)  # type: ignore[arg-type]
                _row(problem)


def _row(problem: ContactProblem) -> None:
    free = problem.boundary == "free"
    size = problem.shape[0]
    unhurried = size < SLOW_FROM or (size == SLOW_FROM and problem.load == LOADS["free"][0])
    solvers: list[Solver | None] = [
        ours,
        aspher_with(backend="fft" if free else "periodic"),
        aspher_with(backend="h2", active_set=True) if free else None,
        contact_mechanics if free and unhurried else None,
        tamaas_solver if unhurried else None,
    ]
    seconds, cells = [], []
    for solver in solvers:
        if solver is None:
            seconds.append(np.inf)
            cells.append("")
            continue
        times = []
        while len(times) < 3 and sum(times) < 10:
            started = time.perf_counter()
            pressure = solver(problem)
            times.append(time.perf_counter() - started)
        seconds.append(min(times))
        cells.append(f"{min(times):.3f} ({residual(problem, pressure):.0e})")
    fraction = float((ours(problem) > 0).mean())
    print(
        f"| {size} | {problem.boundary} | {problem.load:g} | {fraction:.1%} | {' | '.join(cells)} "
        f"| {min(seconds[1:3]) / seconds[0]:.1f} |",
        flush=True,
    )


if __name__ == "__main__":
    main()
