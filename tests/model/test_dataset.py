from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from model.dataset import DatasetConfig, build, read_pairs, read_samples
from model.errors import DatasetError
from solver import solve

CONFIG = DatasetConfig(size=32, count=5, seed=100, hurst_range=(0.3, 0.8), periodic_share=0.5)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("data") / "set"
    build(directory, CONFIG)
    return directory


def contents(directory: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in directory.iterdir()}


def test_files_and_their_bits(built: Path) -> None:
    samples = read_samples(built)
    assert len(samples) == 5
    for sample in samples:
        heights = Image.open(built / sample.heights)
        assert heights.mode == "I;16"
        codes = np.asarray(heights)
        assert (codes.min(), codes.max()) == (0, 65535)
        assert Image.open(built / sample.mask).mode == "1"
        assert sample.status == "CONVERGED"


def test_the_mask_is_the_solution_of_the_stored_heights(built: Path) -> None:
    for (problem, mask), sample in zip(read_pairs(built), read_samples(built), strict=True):
        np.testing.assert_array_equal(mask, solve(problem, tolerance=sample.tolerance).contact_mask)
        assert mask.mean() == pytest.approx(sample.contact_fraction)
        assert problem.load == sample.load_n
        assert 10 <= sample.load_n <= 50
        assert 0.3 <= sample.hurst <= 0.8
        assert np.ptp(problem.heights) == pytest.approx(50e-6)


def test_built_by_two_processes_after_a_stop_it_is_the_same_bit_for_bit(built: Path, tmp_path: Path) -> None:
    build(tmp_path, replace(CONFIG, count=2))
    lines = tmp_path / "samples.jsonl"
    lines.write_text(lines.read_text() + '{"heights": "cut off by a st')
    build(tmp_path, CONFIG, processes=2)
    assert contents(tmp_path) == contents(built)


def test_another_configuration_needs_another_directory(built: Path) -> None:
    before = contents(built)
    with pytest.raises(DatasetError, match="load_range_n"):
        build(built, replace(CONFIG, load_range_n=(1.0, 2.0)))
    assert contents(built) == before


def test_no_data_set_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="asperity dataset"):
        read_samples(tmp_path)
