"""`asperity benchmark`."""

from tests.app.conftest import run


def test_the_benchmarks_are_listed_with_what_they_measure() -> None:
    done = run("benchmark")
    assert done.returncode == 0, done.stderr
    lines = dict(line.split(maxsplit=1) for line in done.stdout.splitlines())
    assert {"hard-cases", "peers", "growth", "multilevel"} <= lines.keys()
    assert "peer-process" not in lines


def test_a_benchmark_runs_with_its_arguments() -> None:
    done = run("benchmark", "growth", "64")
    assert done.returncode == 0, done.stderr
    rows = [line for line in done.stdout.splitlines() if line.startswith("| 64 |")]
    assert len(rows) == 2
    assert all("CONVERGED" in row for row in rows)


def test_an_unknown_benchmark_is_bad_input() -> None:
    done = run("benchmark", "everything")
    assert done.returncode == 2
    assert "hard-cases" in done.stderr
