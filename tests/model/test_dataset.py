import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from model import dataset
from model.dataset import DatasetConfig, build, export, read_pairs, read_shard, shard_paths
from model.errors import DatasetError
from solver import solve

MIDPOINT = DatasetConfig(size=32, count=5, seed=100, hurst_range=(0.3, 0.8))
VARIED = DatasetConfig(size=32, count=20, seed=200, family="varied")


@pytest.fixture(scope="module", params=[MIDPOINT, VARIED], ids=["midpoint", "varied"])
def config(request: pytest.FixtureRequest) -> DatasetConfig:
    return request.param


@pytest.fixture(scope="module")
def built(config: DatasetConfig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("data") / "set"
    build(directory, config)
    return directory


def contents(directory: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in directory.iterdir()}


def test_the_pressure_is_the_solution_on_the_stored_heights(built: Path, config: DatasetConfig) -> None:
    pairs = list(read_pairs(built))
    assert len(pairs) == config.count
    for problem, pressure in pairs:
        solution = solve(problem, tolerance=config.tolerance)
        assert np.count_nonzero((pressure > 0) != solution.contact_mask) <= 1
        assert np.abs(pressure - solution.pressure).max() < 2e-3 * solution.pressure.max()
        assert pressure.sum() * problem.pixel_area == pytest.approx(problem.load, rel=1e-3)
        assert np.ptp(problem.heights) == pytest.approx(50e-6)


def test_midpoint_surfaces_have_the_loads_asked_for(tmp_path: Path) -> None:
    build(tmp_path, MIDPOINT)
    for problem, _ in read_pairs(tmp_path):
        assert 10 <= problem.load <= 50
        assert (problem.boundary, *problem.pixel_size) == ("free", 1e-3 / 32, 1e-3 / 32)


def test_varied_surfaces_reach_from_first_touch_to_much_contact(tmp_path: Path) -> None:
    build(tmp_path, replace(VARIED, count=300))
    pairs = list(read_pairs(tmp_path))
    fractions = [(pressure > 0).mean() for _, pressure in pairs]
    assert min(fractions) < 0.005
    assert max(fractions) > 0.3
    assert {problem.boundary for problem, _ in pairs} == {"free", "periodic"}
    aspects = {problem.pixel_size[0] / problem.pixel_size[1] for problem, _ in pairs}
    assert min(aspects) < 1 < max(aspects)


def test_built_by_two_processes_after_a_stop_it_is_the_same_bit_for_bit(
    built: Path, config: DatasetConfig, tmp_path: Path
) -> None:
    build(tmp_path, replace(config, count=2))
    build(tmp_path, config, processes=2)
    assert contents(tmp_path) == contents(built)


def test_a_device_solves_the_same_problems(built: Path, config: DatasetConfig, tmp_path: Path) -> None:
    build(tmp_path, config, device="cpu")
    (here,), (there,) = (map(read_shard, shard_paths(directory)) for directory in (built, tmp_path))
    np.testing.assert_array_equal(there.codes, here.codes)
    assert [sample.load_n for sample in there.samples] == [sample.load_n for sample in here.samples]
    assert np.abs(there.pressure.astype(float) - here.pressure).max() < 2e-3 * here.pressure.max()


def test_many_samples_are_many_shards_and_one_that_is_missing_is_built_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dataset, "SHARD", 2)
    build(tmp_path, MIDPOINT)
    whole = contents(tmp_path)
    assert len(shard_paths(tmp_path)) == 3
    lines = (tmp_path / "shards.jsonl").read_text().splitlines()
    (tmp_path / "shards.jsonl").write_text("\n".join([lines[0], lines[2]]) + "\n")
    (tmp_path / "00001.safetensors").unlink()
    build(tmp_path, MIDPOINT)
    after = contents(tmp_path)
    assert {name: data for name, data in after.items() if name != "shards.jsonl"} == {
        name: data for name, data in whole.items() if name != "shards.jsonl"
    }
    assert len(shard_paths(tmp_path)) == 3


def test_another_configuration_needs_another_directory(built: Path, config: DatasetConfig) -> None:
    before = contents(built)
    with pytest.raises(DatasetError, match="tolerance"):
        build(built, replace(config, tolerance=1e-3))
    with pytest.raises(DatasetError, match="samples"):
        build(built, replace(config, count=1))
    assert contents(built) == before


def test_a_shard_that_was_changed_is_refused(tmp_path: Path) -> None:
    build(tmp_path, MIDPOINT)
    (path,) = shard_paths(tmp_path)
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(data)
    with pytest.raises(DatasetError, match="not what was stored"):
        shard_paths(tmp_path)


def test_no_data_set_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="asperity dataset"):
        shard_paths(tmp_path)


def test_exported_height_maps_have_their_units_beside_them(tmp_path: Path) -> None:
    build(tmp_path, MIDPOINT)
    export(tmp_path)
    shard = read_shard(shard_paths(tmp_path)[0])
    lines = [json.loads(line) for line in (tmp_path / "samples.jsonl").read_text().splitlines()]
    for line, sample, codes in zip(lines, shard.samples, shard.codes, strict=True):
        image = Image.open(tmp_path / line.pop("heights"))
        assert image.mode == "I;16"
        np.testing.assert_array_equal(np.asarray(image), codes)
        assert line == asdict(sample)
