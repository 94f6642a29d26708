import hashlib
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cases import unlike_training
from model import Surrogate, compare
from model.calibration import QUANTITIES, ErrorBar
from model.errors import WeightsError
from model.methods import METHODS, NETWORK, Method
from model.weights import SHIPPED, load_weights
from solver import ContactProblem, random_midpoint_displacement, solve
from solver.errors import InvalidLoadError
from solver.spectral import spectral_surface

UNSEEN_SEED = 20_000_000


@pytest.fixture(scope="module")
def surrogate() -> Surrogate:
    return Surrogate.load()


def rough(size: int, seed: int, load: float = 30.0, **change: object) -> ContactProblem:
    heights = random_midpoint_displacement(size, seed=UNSEEN_SEED + seed) * 50e-6
    given = {"heights": heights, "pixel_size": (1e-3 / size,) * 2, "load": load, "effective_modulus": 6.843e9}
    return ContactProblem(**(given | change))  # type: ignore[arg-type]


@pytest.mark.parametrize(("size", "floor"), [(64, 0.94), (128, 0.96), (256, 0.96)])
def test_masks_of_unseen_surfaces(surrogate: Surrogate, size: int, floor: float) -> None:
    """Mean Dice over eight surfaces, 10 to 50 N; the floors are those asked of the shipped weights."""
    scores = []
    for seed, load in enumerate(np.linspace(10, 50, 8)):
        problem = rough(size, seed, float(load))
        scores.append(compare(solve(problem).contact_mask, surrogate.estimate(problem).contact_mask).dice)
    assert np.mean(scores) > floor


def test_the_expected_error_is_of_the_size_of_the_error(surrogate: Surrogate) -> None:
    errors, expected = [], []
    for seed in range(12):
        problem = rough(128, 100 + seed)
        prediction = surrogate.estimate(problem)
        errors.append(1 - compare(solve(problem).contact_mask, prediction.contact_mask).dice)
        expected.append(prediction.expected_error.dice)
    assert 0.5 < np.mean(expected) / np.mean(errors) < 2


def test_the_expected_error_holds_on_surfaces_unlike_any_it_was_trained_on(surrogate: Surrogate) -> None:
    """Noise, spikes, terraces, a grating and a checkerboard: errors of one per cent to a hundred."""
    found, expected, covered = [], [], []
    for heights in unlike_training().values():
        for log_load in (-3.0, -2.0, -1.5):
            problem = ContactProblem(heights, (1e-6, 1e-6), 1.0, 1e10)
            scale = problem.effective_modulus * problem.nominal_area * problem.rms_slope
            problem = replace(problem, load=scale * 10**log_load)
            prediction = surrogate.estimate(problem)
            comparison, bars = (
                compare(solve(problem).checked().contact_mask, prediction.contact_mask),
                prediction.expected_error,
            )
            found += [1 - comparison.dice, abs(comparison.area_error)]
            expected += [bars.dice, bars.contact_area]
            covered += [1 - comparison.dice <= bars.dice_bound, abs(comparison.area_error) <= bars.contact_area_bound]
    assert np.mean(covered) > 0.8
    assert 0.5 < np.mean(expected) / np.mean(found) < 2
    assert np.corrcoef(np.log(expected), np.log(found))[0, 1] > 0.8


def test_the_same_problem_gives_the_same_mask_in_any_units(surrogate: Surrogate) -> None:
    problem = rough(64, 200)
    prediction = surrogate.estimate(problem)
    np.testing.assert_array_equal(surrogate.estimate(problem).probability, prediction.probability)
    softer = rough(64, 200, 3.0, effective_modulus=6.843e8)
    assert compare(prediction.contact_mask, surrogate.estimate(softer).contact_mask).dice > 0.995


def test_more_load_means_more_contact(surrogate: Surrogate) -> None:
    fractions = [surrogate.estimate(rough(128, 300, load)).contact_mask.mean() for load in (5.0, 10.0, 20.0, 50.0, 100.0)]
    assert fractions == sorted(fractions)


@pytest.mark.parametrize("shape", [(16, 200), (50, 17), (100, 60)])
def test_any_shape(surrogate: Surrogate, shape: tuple[int, int]) -> None:
    heights = random_midpoint_displacement(256, seed=7)[: shape[0], : shape[1]] * 50e-6
    prediction = surrogate.estimate(ContactProblem(heights, (4e-6, 4e-6), 1.0, 6.843e9))
    assert prediction.method == "surrogate"
    assert prediction.contact_mask.shape == prediction.probability.shape == shape
    assert prediction.contact_mask.any()


@pytest.mark.parametrize("heights", [np.random.default_rng(0).random((5, 40)) * 1e-6, np.zeros((64, 64))])
def test_what_is_too_small_or_flat_is_solved(surrogate: Surrogate, heights: np.ndarray) -> None:
    problem = ContactProblem(heights, (1e-6, 1e-6), 1e-2, 1e9)
    prediction = surrogate.predict(problem)
    assert prediction.method == "solver"
    np.testing.assert_array_equal(prediction.contact_mask, solve(problem).contact_mask)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: f"{method.start} {method.tolerance:g}")
def test_the_pressure_carries_the_load_on_the_mask(surrogate: Surrogate, method: Method) -> None:
    problem = rough(128, 500)
    prediction = surrogate.answer(problem, method)
    np.testing.assert_array_equal(prediction.pressure > 0, prediction.contact_mask)
    assert prediction.pressure.sum() * problem.pixel_area == pytest.approx(problem.load, rel=1e-6)


def test_a_hardness_is_left_to_the_solver(surrogate: Surrogate) -> None:
    problem = rough(64, 600, hardness=1e9)
    prediction = surrogate.predict(problem)
    assert prediction.method == "solver"
    assert prediction.pressure.max() <= 1e9


def test_loads_beyond_training_are_said_to_be_so(surrogate: Surrogate) -> None:
    assert surrogate.estimate(rough(64, 400, 30.0)).in_distribution
    assert not surrogate.estimate(rough(64, 400, 30e6)).in_distribution
    assert not surrogate.estimate(rough(64, 400, 1e-6)).in_distribution


def test_weights_are_loaded_by_hash(tmp_path: Path) -> None:
    copy = tmp_path / "weights"
    shutil.copytree(SHIPPED, copy)
    assert Surrogate.load(copy).version == Surrogate.load().version
    weights = copy / "network.safetensors"
    data = bytearray(weights.read_bytes())
    data[-1] ^= 1
    weights.write_bytes(data)
    with pytest.raises(WeightsError, match="hash"):
        Surrogate.load(copy)
    sha256, other = Surrogate.load().weights.manifest["sha256"], hashlib.sha256(data).hexdigest()
    (copy / "manifest.json").write_text((copy / "manifest.json").read_text().replace(sha256, other))
    assert Surrogate.load(copy).estimate(rough(32, 0)).expected_error.largest == 1
    weights.unlink()
    with pytest.raises(WeightsError, match="missing"):
        Surrogate.load(copy)


def test_shipped_weights_are_small() -> None:
    assert (SHIPPED / "network.safetensors").stat().st_size < 16e6


@pytest.mark.parametrize("size", [32, 128, 256])
def test_the_more_accuracy_is_asked_for_the_better_the_answer(surrogate: Surrogate, size: int) -> None:
    problem = rough(size, 700)
    reference = solve(problem).contact_mask
    errors = {}
    for accuracy in ("fast", "balanced", "exact"):
        prediction = surrogate.predict(problem, accuracy)  # type: ignore[arg-type]
        errors[accuracy] = 1 - compare(reference, prediction.contact_mask).dice
        assert prediction.pressure.sum() * problem.pixel_area == pytest.approx(problem.load, rel=1e-6)
    assert errors["fast"] < 0.06
    assert errors["balanced"] < 0.03
    assert errors["exact"] == 0


def test_an_estimate_that_doubts_itself_is_solved_further(surrogate: Surrogate) -> None:
    """Where the table says that the network will do, its own error bar has the last word."""
    ways = surrogate.weights.ways
    assert ways is not None
    cheap = [replace(one, milliseconds=0.0) if one.method == NETWORK else one for one in ways.measured]
    eager = Surrogate(replace(load_weights(), ways=replace(ways, measured=tuple(cheap))))
    problem = rough(128, 800)
    assert eager.predict(problem, 0.5).method == "surrogate"
    own = eager.estimate(problem).expected_error.largest
    sure = [
        replace(one, errors=dict.fromkeys(QUANTITIES, ErrorBar(0.0, 0.0))) if one.method == NETWORK else one for one in cheap
    ]
    sceptical = Surrogate(replace(load_weights(), ways=replace(ways, measured=tuple(sure))))
    assert sceptical.predict(problem, own * 1.01).method == "surrogate"
    assert sceptical.predict(problem, own * 0.99).method != "surrogate"


def test_a_solve_that_stopped_too_early_by_its_own_account_goes_on(surrogate: Surrogate) -> None:
    """Where the table says that a tolerance of 0.1 will do, the error bar of that answer has the last word."""
    ways = surrogate.weights.ways
    assert ways is not None
    loose, none = Method("coarse", 1e-1), dict.fromkeys(QUANTITIES, ErrorBar(0.0, 0.0))
    sure = [replace(one, milliseconds=0.0, errors=none) if one.method == loose else one for one in ways.measured]
    eager = Surrogate(replace(load_weights(), ways=replace(ways, measured=tuple(sure))))
    problem = rough(128, 1500)
    reference, stopped = solve(problem).contact_mask, eager.answer(problem, loose)
    own = stopped.expected_error.largest
    np.testing.assert_array_equal(eager.predict(problem, own * 1.01).contact_mask, stopped.contact_mask)
    further = eager.predict(problem, own * 0.99)
    assert further.method == "solver"
    assert further.expected_error.largest <= own * 0.99
    assert compare(reference, further.contact_mask).dice > compare(reference, stopped.contact_mask).dice


@pytest.mark.parametrize(
    "shape", [{"hurst": 0.8, "anisotropy": 5.0}, {"hurst": 0.9, "shortest_wavelength": 8.0}, {"hurst": 0.4}]
)
def test_what_is_served_is_as_wrong_as_it_says(surrogate: Surrogate, shape: dict[str, float]) -> None:
    """On smooth surfaces too, where a solve that stops early is far less accurate than on rough ones."""
    errors, expected, bounds = [], [], []
    for seed in range(8):
        heights = spectral_surface((128, 128), (1.0, 1.0), rms_height=1.0, seed=UNSEEN_SEED + seed, **shape)  # type: ignore[arg-type]
        problem = ContactProblem(heights * 1e-6, (1e-5, 1e-5), 1.0, 1e9)
        problem = replace(problem, load=0.03 * problem.effective_modulus * problem.nominal_area * problem.rms_slope)
        prediction = surrogate.predict(problem)
        errors.append(1 - compare(solve(problem).contact_mask, prediction.contact_mask).dice)
        expected.append(prediction.expected_error.dice)
        bounds.append(prediction.expected_error.dice_bound)
    assert np.mean(errors) < 0.01
    assert np.mean(errors) < 2 * np.mean(expected)
    assert np.mean(np.array(errors) <= bounds) > 0.7


def test_the_error_expected_of_a_solve_that_stops_early_is_of_the_size_of_its_error(surrogate: Surrogate) -> None:
    for method in (Method("coarse", 1e-1), Method("coarse", 1e-2), Method("network", 1e-2)):
        errors, expected, bounded = [], [], []
        for seed in range(12):
            problem = rough(128, 1400 + seed)
            prediction = surrogate.answer(problem, method)
            errors.append(1 - compare(solve(problem).contact_mask, prediction.contact_mask).dice)
            expected.append(prediction.expected_error.dice)
            bounded.append(errors[-1] <= prediction.expected_error.dice_bound)
        assert 0.3 < np.mean(expected) / np.mean(errors) < 3
        assert np.mean(bounded) > 0.6


def test_a_batch_of_estimates_is_its_problems_one_by_one(surrogate: Surrogate) -> None:
    problems = [rough(64, 900, load) for load in (5.0, 30.0, 100.0)]
    for one, problem in zip(surrogate.estimate_batch(problems), problems, strict=True):
        assert compare(surrogate.estimate(problem).contact_mask, one.contact_mask).dice > 0.99


def test_a_sweep_is_nearly_its_loads_one_by_one(surrogate: Surrogate) -> None:
    problem, loads = rough(128, 1000), [50.0, 10.0, 17.0, 23.0, 31.0, 10.5, 42.0, 12.0, 14.0, 19.0]
    swept = surrogate.estimate_sweep(problem, loads)
    for load, one in zip(loads, swept, strict=True):
        alone = surrogate.estimate(rough(128, 1000, load))
        assert compare(alone.contact_mask, one.contact_mask).dice > 0.97
        assert one.expected_error.dice == pytest.approx(alone.expected_error.dice, rel=0.3)
        assert one.pressure.sum() * problem.pixel_area == pytest.approx(load, rel=1e-6)
        assert one.in_distribution
    areas = [int(one.contact_mask.sum()) for _, one in sorted(zip(loads, swept, strict=True), key=lambda pair: pair[0])]
    assert areas == sorted(areas)


def test_a_sweep_at_an_accuracy_is_as_accurate_at_every_load(surrogate: Surrogate) -> None:
    problem, loads = rough(256, 1600), [80.0, 5.0, 20.0]
    swept = list(surrogate.predict_sweep(problem, loads, 0.01))
    for load, one in zip(loads, swept, strict=True):
        assert compare(solve(replace(problem, load=load)).contact_mask, one.contact_mask).dice > 0.98
        assert one.expected_error.largest <= 0.01
        assert one.pressure.sum() * problem.pixel_area == pytest.approx(load, rel=1e-6)
    (exact,) = surrogate.predict_sweep(problem, [30.0], "exact")
    np.testing.assert_array_equal(exact.contact_mask, solve(problem).contact_mask)
    with pytest.raises(InvalidLoadError):
        list(surrogate.predict_sweep(problem, [30.0, -1.0]))


@pytest.mark.parametrize("loads", [[30.0], [30.0, 30.0], [1.0, 300.0]])
def test_a_sweep_of_few_loads_is_exactly_they(surrogate: Surrogate, loads: list[float]) -> None:
    swept = surrogate.estimate_sweep(rough(64, 1100), loads)
    for load, one in zip(loads, swept, strict=True):
        assert compare(surrogate.estimate(rough(64, 1100, load)).contact_mask, one.contact_mask).dice > 0.99


def test_a_sweep_has_a_load(surrogate: Surrogate) -> None:
    with pytest.raises(InvalidLoadError):
        surrogate.estimate_sweep(rough(64, 1100), [])


def test_a_periodic_map_may_begin_anywhere(surrogate: Surrogate) -> None:
    """Rolled by a multiple of the coarse pixels, the mask rolls along, but for what interpolation does at the edges."""
    problem = rough(128, 1200, boundary="periodic")
    rolled = replace(problem, heights=np.roll(problem.heights, (32, 64), (0, 1)))
    mask = np.roll(surrogate.estimate(problem).contact_mask, (32, 64), (0, 1))
    assert compare(mask, surrogate.estimate(rolled).contact_mask).dice > 0.97


def test_a_large_map_in_tiles_is_nearly_the_map_as_a_whole(surrogate: Surrogate, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = rough(512, 1300)
    whole = surrogate.estimate(problem).contact_mask
    monkeypatch.setattr("model.tiles.TILE", 192)
    assert compare(whole, surrogate.estimate(problem).contact_mask).dice > 0.99
