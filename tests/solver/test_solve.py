import numpy as np
import pytest
import tamaas
from ContactMechanics import FreeFFTElasticHalfSpace
from ContactMechanics.Optimization import constrained_conjugate_gradients
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import ContactProblem, InvalidProblemError, Status, random_midpoint_displacement, solve
from solver.closed_forms import SQUARE_PUNCH_STIFFNESS, HertzSphere, WestergaardSinusoid
from tests.solver.conftest import PAPER_MODULUS, contact_violation


def rough(size: int, seed: int, load: float, **change: object) -> ContactProblem:
    """The paper's surfaces: 1 mm square, heights from 0 to 50 um."""
    heights = random_midpoint_displacement(size, seed=seed) * 50e-6
    side = 1e-3 / size
    given = {"heights": heights, "pixel_size": (side, side), "load": load, "effective_modulus": PAPER_MODULUS}
    return ContactProblem(**(given | change))  # type: ignore[arg-type]


def test_hertz_sphere() -> None:
    """A sphere's contact radius and peak pressure within 1 % at 256 x 256."""
    sphere = HertzSphere(radius=10e-3, load=5.0, effective_modulus=100e9)
    size, side = 256, 4 * sphere.contact_radius
    centres = (np.arange(size) + 0.5) / size * side - side / 2
    r = np.hypot(*np.meshgrid(centres, centres))
    solution = solve(ContactProblem(-(r**2) / (2 * sphere.radius), (side / size, side / size), 5.0, 100e9))
    assert solution.status is Status.CONVERGED
    radius = np.sqrt(solution.contact_mask.sum() * (side / size) ** 2 / np.pi)
    assert radius == pytest.approx(sphere.contact_radius, rel=0.01)
    assert solution.pressure.max() == pytest.approx(sphere.peak_pressure, rel=0.01)
    assert solution.approach == pytest.approx(sphere.approach, rel=0.01)
    inside = r < 0.9 * sphere.contact_radius
    np.testing.assert_allclose(solution.pressure[inside], sphere.pressure(r)[inside], rtol=0.02)


@pytest.mark.parametrize("axis", [0, 1])
def test_sinusoid_in_full_contact(axis: int) -> None:
    """Pressure of a completely flattened sinusoid within 1e-6."""
    wave = WestergaardSinusoid(amplitude=1e-6, wavelength=100e-6, effective_modulus=50e9)
    x = np.arange(64) / 64 * wave.wavelength
    mean = 1.5 * wave.full_contact_pressure
    heights = np.tile(wave.amplitude * np.cos(2 * np.pi * x / wave.wavelength), (48, 1))
    pixel_size = (2e-6, 100e-6 / 64)
    expected = np.tile(wave.pressure(x, mean), (48, 1))
    if axis == 0:
        heights, pixel_size, expected = heights.T, pixel_size[::-1], expected.T
    problem = ContactProblem(heights, pixel_size, mean * 48 * 2e-6 * 100e-6, 50e9, "periodic")
    solution = solve(problem, tolerance=1e-9)
    assert solution.contact_fraction == 1
    np.testing.assert_allclose(solution.pressure, expected, rtol=1e-6)


def test_sinusoid_in_partial_contact() -> None:
    wave = WestergaardSinusoid(amplitude=1e-6, wavelength=100e-6, effective_modulus=50e9)
    x = np.arange(512) / 512 * wave.wavelength
    mean = 0.4 * wave.full_contact_pressure
    heights = np.tile(wave.amplitude * np.cos(2 * np.pi * x / wave.wavelength), (4, 1))
    solution = solve(ContactProblem(heights, (1e-6, 100e-6 / 512), mean * 4e-6 * 100e-6, 50e9, "periodic"))
    width = solution.contact_mask[0].sum() * 100e-6 / 512
    assert width == pytest.approx(2 * wave.contact_half_width(mean), rel=0.01)
    centre = solution.pressure[0] > 0.5 * solution.pressure.max()
    np.testing.assert_allclose(solution.pressure[0][centre], wave.pressure(x, mean)[centre], rtol=0.01)


def test_flat_square_punch() -> None:
    """Stiffness of a rigid square punch approaches 1.152 E* L as the grid is refined, its error halved with the pixels."""
    errors = []
    for size in (32, 64, 128):
        side = 1e-3 / size
        solution = solve(ContactProblem(np.zeros((size, size)), (side, side), 10.0, 1e9))
        assert solution.contact_fraction == 1
        errors.append(10.0 / (1e9 * 1e-3 * solution.approach) / SQUARE_PUNCH_STIFFNESS - 1)
    assert errors[0] < errors[1] < errors[2] < 0
    assert abs(errors[2]) < 0.003
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(2, rel=0.1)


@pytest.mark.parametrize("size", [128, 256])
@pytest.mark.parametrize(("seed", "load"), [(11, 10.0), (12, 30.0), (13, 200.0)])
def test_masks_equal_those_of_other_packages(size: int, seed: int, load: float) -> None:
    """Not one pixel differs from ContactMechanics (free) or Tamaas (periodic) at a tolerance of 1e-8."""
    free = rough(size, seed, load)
    substrate = FreeFFTElasticHalfSpace((size, size), PAPER_MODULUS, (1e-3, 1e-3))
    theirs = constrained_conjugate_gradients(
        substrate,
        np.array(free.heights),
        external_force=load,
        pentol=1e-8 * free.rms_height,
        forcetol=1e-10,
        thermotol=1e-8,
        maxiter=5000,
    )
    ours = solve(free, tolerance=1e-8)
    assert ours.status is Status.CONVERGED
    assert np.count_nonzero(ours.contact_mask != (theirs.jac > 0)) == 0

    tamaas.set_log_level(tamaas.LogLevel.error)
    periodic = rough(size, seed, load, boundary="periodic")
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1e-3, 1e-3], [size, size])
    model.E, model.nu = PAPER_MODULUS, 0
    tamaas.PolonskyKeerRey(model, np.array(periodic.heights), 1e-12).solve(periodic.nominal_pressure)
    ours = solve(periodic, tolerance=1e-8)
    assert ours.status is Status.CONVERGED
    assert np.count_nonzero(ours.contact_mask != (model.traction > 0)) == 0


def test_gap_and_pressure_satisfy_the_contact_conditions() -> None:
    problem = rough(64, 3, 30.0)
    solution = solve(problem)
    assert contact_violation(problem, solution) == pytest.approx(solution.residual, rel=0.5, abs=1e-9)
    assert solution.residual <= 1e-6
    assert solution.gap.min() >= -1e-6 * problem.rms_height
    assert np.abs(solution.gap[solution.contact_mask]).max() < 1e-2 * problem.rms_height


def test_stopping_early_returns_the_best_so_far_and_says_so() -> None:
    problem = rough(64, 4, 30.0)
    residuals = []
    for iterations in (1, 5, 10):
        solution = solve(problem, max_iterations=iterations)
        assert solution.status is Status.ITERATION_LIMIT
        assert solution.iterations == iterations
        assert contact_violation(problem, solution) > 1e-6
        residuals.append(solution.residual)
    assert residuals[0] > residuals[-1]


def test_unreachable_tolerance_is_never_claimed() -> None:
    problem = rough(32, 5, 30.0)
    solution = solve(problem, tolerance=1e-19)
    assert solution.status is Status.STAGNATED
    assert contact_violation(problem, solution) < 1e-10


def test_iterations_are_reported_and_an_exception_stops_the_solve() -> None:
    class StopSolveError(Exception):
        pass

    seen: list[tuple[int, float]] = []

    def on_iteration(iteration: int, residual: float) -> None:
        seen.append((iteration, residual))
        if iteration == 5:
            raise StopSolveError

    with pytest.raises(StopSolveError):
        solve(rough(64, 6, 30.0), on_iteration=on_iteration)
    assert [iteration for iteration, _ in seen] == [1, 2, 3, 4, 5]
    assert all(residual > 0 for _, residual in seen)


def test_a_good_start_is_taken_up() -> None:
    problem = rough(64, 7, 30.0)
    cold = solve(problem)
    warm = solve(problem, initial_pressure=cold.pressure * 2)
    assert warm.iterations <= 1
    np.testing.assert_array_equal(warm.contact_mask, cold.contact_mask)


@pytest.mark.parametrize(
    "arguments",
    [
        {"method": "magic"},
        {"tolerance": 0.0},
        {"tolerance": float("nan")},
        {"initial_pressure": np.ones((3, 3))},
        {"initial_pressure": np.full((32, 32), np.nan)},
        {"initial_pressure": np.zeros((32, 32))},
    ],
)
def test_bad_arguments_are_refused(arguments: dict[str, object]) -> None:
    with pytest.raises(InvalidProblemError):
        solve(rough(32, 8, 30.0), **arguments)  # type: ignore[arg-type]


powers = st.floats(-6, 6).map(lambda exponent: 10.0**exponent)


@settings(max_examples=20, deadline=None)
@given(lengths=powers, modulus=powers, boundary=st.sampled_from(["free", "periodic"]))
def test_units_do_not_matter(lengths: float, modulus: float, boundary: str) -> None:
    """Scaling all lengths, or modulus and load, leaves the mask and scales the pressure."""
    heights = random_midpoint_displacement(32, seed=9)
    reference = solve(ContactProblem(heights, (1.0, 2.0), 40.0, 1.0, boundary), tolerance=1e-9)  # type: ignore[arg-type]
    load = 40.0 * modulus * lengths**2
    scaled = solve(
        ContactProblem(heights * lengths, (lengths, 2 * lengths), load, modulus, boundary),  # type: ignore[arg-type]
        tolerance=1e-9,
    )
    np.testing.assert_array_equal(scaled.contact_mask, reference.contact_mask)
    np.testing.assert_allclose(scaled.pressure / modulus, reference.pressure, rtol=1e-3, atol=1e-6)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000), load=st.floats(0.1, 300.0), offset=st.floats(-1e-3, 1e-3))
def test_symmetries(seed: int, load: float, offset: float) -> None:
    """Transposing, flipping and lifting the surface do the same to the solution."""
    problem = rough(32, seed, load, pixel_size=(20e-6, 31.25e-6))
    mask = solve(problem, tolerance=1e-9).contact_mask
    turned = rough(32, seed, load, heights=problem.heights.T + offset, pixel_size=(31.25e-6, 20e-6))
    np.testing.assert_array_equal(solve(turned, tolerance=1e-9).contact_mask.T, mask)
    flipped = rough(32, seed, load, heights=problem.heights[::-1, ::-1], pixel_size=problem.pixel_size)
    np.testing.assert_array_equal(solve(flipped, tolerance=1e-9).contact_mask[::-1, ::-1], mask)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 1000), load=st.floats(0.01, 1000.0))
def test_more_load_means_more_contact_and_approach(seed: int, load: float) -> None:
    light, heavy = solve(rough(32, seed, load)), solve(rough(32, seed, 1.2 * load))
    assert heavy.contact_mask.sum() >= light.contact_mask.sum()
    assert heavy.approach > light.approach


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    shape=st.tuples(st.integers(4, 40), st.integers(4, 40)),
    exponent=st.floats(-6, 6),
    boundary=st.sampled_from(["free", "periodic"]),
    spikes=st.integers(0, 3),
)
def test_any_surface_converges_to_a_solution(
    seed: int, shape: tuple[int, int], exponent: float, boundary: str, spikes: int
) -> None:
    """Noise, with spikes twenty times its height, at loads over twelve decades."""
    generator = np.random.default_rng(seed)
    heights = generator.standard_normal(shape) * 1e-6
    heights.ravel()[generator.integers(0, heights.size, spikes)] += 20e-6
    problem = ContactProblem(heights, (1e-6, 1e-6), 10.0**exponent, 1e9, boundary)  # type: ignore[arg-type]
    solution = solve(problem)
    assert solution.status is Status.CONVERGED
    assert contact_violation(problem, solution) < 2e-6
