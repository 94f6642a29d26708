from dataclasses import replace

import pytest

from model.calibration import QUANTITIES, ErrorBar
from model.errors import AccuracyError
from model.methods import METHODS, NETWORK, SOLVED, Measured, Ways, choose, restored, stored, tabulated, target_of


def measured() -> list[Measured]:
    """The network costs 10 ms at 64 x 64 and 20 ms at 256 x 256; the full solve 1 ms and 100 ms; the others in between."""
    found = []
    for pixels, network, full in ((64**2, 10.0, 1.0), (256**2, 20.0, 100.0)):
        for load in (-3.0, -1.0):
            for method in METHODS:
                cost = network if method == NETWORK else full if method == SOLVED else (network + full) / 2
                error = 0.02 if method == NETWORK else 0.0 if method == SOLVED else 0.005
                bars = {quantity: ErrorBar(error, 2 * error) for quantity in QUANTITIES}
                found.append(Measured(method, pixels, load, cost, bars))
    return found


def test_the_cheapest_that_is_accurate_enough_comes_first() -> None:
    assert choose(0.03, 64**2, -2.0, tabulated(measured()))[0].method == SOLVED
    assert choose(0.03, 256**2, -2.0, tabulated(measured()))[0].method == NETWORK
    assert choose(0.01, 256**2, -2.0, tabulated(measured()))[0].method not in (NETWORK, SOLVED)
    assert [choice.method for choice in choose(0.0, 256**2, -2.0, tabulated(measured()))] == [SOLVED]


def test_between_and_beyond_the_sizes_measured_costs_follow() -> None:
    costs = [choose(0.0, size**2, -2.0, tabulated(measured()))[0].milliseconds for size in (32, 64, 128, 256, 512)]
    assert costs[0] == pytest.approx(costs[1])
    assert costs[1] < costs[2] < costs[3]
    assert costs[4] == pytest.approx(4 * costs[3])


def test_the_load_measured_nearest_counts() -> None:
    """Under the heavier load everything but the full solve is bad."""
    bad = dict.fromkeys(QUANTITIES, ErrorBar(0.5, 0.9))
    rows = [replace(one, errors=bad) if one.log_load > -2 and one.method != SOLVED else one for one in measured()]
    assert choose(0.03, 256**2, -2.9, tabulated(rows))[0].method == NETWORK
    assert choose(0.03, 256**2, -1.2, tabulated(rows))[0].method == SOLVED


def test_measurements_are_stored_and_restored() -> None:
    network, stopped = (
        {quantity: {"coefficients": [0.1, 1.0, 0.5], "factor": factor} for quantity in QUANTITIES} for factor in (2.0, 3.0)
    )
    ways = Ways(tuple(measured()), network, stopped)
    assert restored(stored(ways, "one hash"), "one hash") == ways
    assert restored(stored(ways, "one hash"), "another hash") is None


def test_accuracies() -> None:
    assert target_of("exact") == 0 < target_of("balanced") < target_of("fast") < 0.05
    assert target_of(0.5) == 0.5


@pytest.mark.parametrize("accuracy", ["precise", -0.1, 1.5, float("nan")])
def test_other_accuracies_are_refused(accuracy: object) -> None:
    with pytest.raises(AccuracyError, match="balanced"):
        target_of(accuracy)  # type: ignore[arg-type]
