"""The surfaces that the surrogate is tested on; their seeds are in no training set."""

from dataclasses import dataclass

from model.dataset import DatasetConfig
from model.families import Family

TEST_SEED = 10_000_000
"""First surface seed of the test sets; training seeds stay below."""

SIZES = (32, 64, 128, 256, 512)
LOADS_N = (10.0, 20.0, 30.0, 40.0, 50.0)
PAPER_BY_SIZE = (0.9169, 0.9129, 0.9188, 0.9138, 0.9154)
PAPER_BY_LOAD = (0.9002, 0.9384, 0.9535, 0.9406, 0.9117)


@dataclass(frozen=True)
class HeldOutSet:
    """A data set with a name, and the Dice of the paper on one like it."""

    group: str
    name: str
    config: DatasetConfig
    paper: float | None = None


def held_out_sets(count: int) -> list[HeldOutSet]:
    """All test sets; ``count`` is the number of maps up to 128 x 128, larger ones have fewer."""
    by_size = [
        HeldOutSet(
            "by scale, 30 N",
            f"{size} x {size}",
            DatasetConfig(size=size, count=_fewer(count, size), seed=TEST_SEED, load_range_n=(30.0, 30.0)),
            paper,
        )
        for size, paper in zip(SIZES, PAPER_BY_SIZE, strict=True)
    ]
    by_load = [
        HeldOutSet(
            "by load, 128 x 128",
            f"{load:g} N",
            DatasetConfig(count=count, seed=TEST_SEED + 100_000, load_range_n=(load, load)),
            paper,
        )
        for load, paper in zip(LOADS_N, PAPER_BY_LOAD, strict=True)
    ]
    by_kind = [
        HeldOutSet(
            "other surfaces, 128 x 128",
            f"Hurst exponent {hurst:g}",
            DatasetConfig(count=count, seed=TEST_SEED + 200_000, hurst_range=(hurst, hurst)),
        )
        for hurst in (0.2, 0.8)
    ]
    spectral: tuple[Family, ...] = ("roll-off", "anisotropic", "skewed")
    by_kind += [
        HeldOutSet(
            "other surfaces, 128 x 128",
            f"spectral, {family}",
            DatasetConfig(count=count, seed=TEST_SEED + 250_000, family=family, hurst_range=(0.8, 0.8)),
        )
        for family in spectral
    ]
    by_kind += [
        HeldOutSet(
            "other surfaces, 128 x 128",
            "little contact, 0.5 to 3 N",
            DatasetConfig(count=count, seed=TEST_SEED + 300_000, load_range_n=(0.5, 3.0)),
        ),
        HeldOutSet(
            "other surfaces, 128 x 128",
            "varied, both boundaries",
            DatasetConfig(count=2 * count, seed=TEST_SEED + 400_000, family="varied"),
        ),
    ]
    return by_size + by_load + by_kind


def _fewer(count: int, size: int) -> int:
    return max(8, count * 128 // max(size, 128))
