from dataclasses import replace

import numpy as np
import pytest
import torch

from model.domain import STATISTICS, domain_of, outside, statistics
from model.features import features, log_load
from solver import ContactProblem, random_midpoint_displacement

PROBLEMS = [
    ContactProblem(random_midpoint_displacement(64, seed=seed) * 50e-6, (1e-3 / 64, 1e-3 / 64), load, 6.843e9)
    for seed, load in enumerate(np.geomspace(1, 100, 12))
]
DOMAIN = domain_of(statistics(features(PROBLEMS)))


def reasons(problem: ContactProblem) -> tuple[str, ...]:
    return outside(statistics(features([problem]))[0], DOMAIN)


def test_statistics_are_those_of_the_problem() -> None:
    problem = replace(PROBLEMS[3], pixel_size=(3e-5, 1e-5))
    found = dict(zip(STATISTICS, statistics(features([problem]))[0].tolist(), strict=True))
    deviations = problem.heights - problem.heights.mean()
    assert found["load"] == pytest.approx(log_load(problem), abs=1e-5)
    assert found["aspect"] == pytest.approx(np.log(3))
    assert found["skewness"] == pytest.approx((deviations**3).mean() / (deviations**2).mean() ** 1.5, abs=1e-4)
    assert 10 ** found["kurtosis"] == pytest.approx((deviations**4).mean() / (deviations**2).mean() ** 2, rel=1e-4)


def test_what_was_seen_lies_within_and_units_do_not_matter() -> None:
    for problem in PROBLEMS[2:-2]:
        scaled = ContactProblem(problem.heights * 1e3, (1e3 / 64 * 1e-3,) * 2, problem.load * 1e6, problem.effective_modulus)
        assert {*reasons(problem)} == {*reasons(scaled)}
    assert sum(not reasons(problem) for problem in PROBLEMS) >= 6


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"load": 1e5}, "load"),
        ({"load": 1e-4}, "load"),
        ({"pixel_size": (1e-3 / 64, 1e-2 / 64)}, "aspect"),
        ({"heights": np.where(np.arange(4096).reshape(64, 64) == 77, 1e-3, PROBLEMS[5].heights)}, "kurtosis"),
        ({"heights": np.random.default_rng(0).standard_normal((64, 64)) * 1e-6, "load": 1.0}, "roughness"),
    ],
)
def test_what_lies_outside_is_told_with_its_reason(change: dict[str, object], word: str) -> None:
    told = reasons(replace(PROBLEMS[5], **change))  # type: ignore[arg-type]
    assert any(word in reason and "as in training" in reason for reason in told)


def test_the_domain_leaves_out_the_rarest() -> None:
    values = torch.randn(100_000, len(STATISTICS))
    for lowest, highest in domain_of(values).values():
        assert lowest == pytest.approx(-3.29, abs=0.15)
        assert highest == pytest.approx(3.29, abs=0.15)
