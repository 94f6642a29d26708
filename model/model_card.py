"""The model card: what the weights are, how they were made, what they reach and what they cost."""

from collections.abc import Mapping, Sequence
from typing import Any

from model.held_out import TEST_SEED
from model.methods import METHODS, NETWORK, Measured
from model.metrics import BOUNDARY_TOLERANCE
from model.outcome import Row
from model.surrogate import Surrogate
from model.worst_cases import Judged, explained


def model_card(
    surrogate: Surrogate,
    rows: Mapping[str, Sequence[Row]],
    measured: Sequence[Measured],
    pictures: Mapping[str, str],
    worst: Sequence[Judged],
) -> str:
    """The card as Markdown.

    Args:
        surrogate: whose card it is.
        rows: by way to answer.
        measured: ways to answer.
        pictures: captions by file, relative to the card.
        worst: cases.
    """
    manifest = surrogate.weights.manifest
    builds = "\n".join(
        f"    {_build_command(name, data)}" for name, data in manifest["datasets"].items() if "family" in data
    )
    problems = sum(data["count"] for data in manifest["datasets"].values())
    trainings = "\n".join(_train_command(number, stage) for number, stage in enumerate(manifest["training"], start=1))
    parameters = sum(parameter.numel() for parameter in surrogate.weights.network.parameters())
    drawn = "\n".join(f"![{caption}]({file})\n\n{caption}\n" for file, caption in pictures.items())
    tables = "\n".join(f"### {name.capitalize()}\n\n{table(found)}" for name, found in rows.items())
    return f"""# Model card: {surrogate.version}

Written by `asperity evaluate`; every number on this page comes from that command or from the manifest of the weights.

**What it is.** A U-Net on half the resolution (`model/network.py`, {parameters / 1e6:.2f} million parameters) that predicts
where a rough surface under a load touches a flat, and the pressure there. Its input is dimensionless: the gap and the
pressure of a solve on a four times coarser grid, the load, and the aspect of the pixels (`model/features.py`). SHA-256 of
the weights: `{manifest["sha256"]}`.

**Data.** {problems:,} problems: random midpoint and spectral surfaces, Hurst exponents 0.2 to 0.9, with roll-off,
anisotropy, skewness, form, lay and noise, both boundaries, loads from first touch to two fifths of the map
(`model/families.py`). A tenth of the surface seeds was held out for validation and a tenth for tests.

{builds}
{trainings}

**What it reaches** on surfaces it never saw (seeds from {TEST_SEED}; random midpoint surfaces with Hurst exponent 0.5, free
boundary, E* = 6.843 GPa and 10 to 50 N unless said). BF tolerance {BOUNDARY_TOLERANCE} pixels; resistance by Boyer's
formula on both masks; `paper` is the Dice coefficient in Tables 1 and 2 of the paper. `expected / found` are means of
1 - Dice, and `covered` is the share of maps whose error lies below the bound that should hold for 90 %. Times are of the
machine that wrote this page.

{tables}
## Pictures, network alone

{drawn}
The worst of them, and why: where little touches, each pixel at the edge of a spot counts for much.

{explained(worst)}
## What every way to answer costs

Mean 1 - Dice and median ms on two cores of the machine that wrote this page, on midpoint, varied and smooth surfaces (the
last anisotropic or skewed, with Hurst exponent 0.8); `network 0.1` is the solver to a tolerance of 0.1 started from the
network's pressure, `coarse 0.1` from its own start. The service takes the cheapest that is accurate enough on average, and
has the solver go on where the error bar of the answer says that it is not (`model/methods.py`).

{_ways(measured)}
"""


def table(rows: Sequence[Row]) -> str:
    """The rows as a Markdown table."""
    lines = [
        "| surfaces | maps | Dice | paper | 5th percentile | Jaccard | BF | pixel accuracy | area error (bias) "
        "| resistance error | expected / found | covered | median ms | answered by |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        answered = ", ".join(f"{name} {count}" for name, count in row.methods.items())
        lines.append(
            f"| {row.group}: {row.name} | {row.maps} | {row.dice:.4f} | {row.paper or ''} | {row.dice_5th_percentile:.4f} "
            f"| {row.jaccard:.4f} | {row.bf_score:.4f} | {row.pixel_accuracy:.4f} "
            f"| {row.area_error:.2%} ({row.area_bias:+.2%}) | {row.resistance_error:.2%} "
            f"| {row.expected:.4f} / {1 - row.dice:.4f} | {row.covered:.0%} | {row.milliseconds:.1f} | {answered} |"
        )
    return "\n".join(lines) + "\n"


def _ways(measured: Sequence[Measured]) -> str:
    names = ["network" if method == NETWORK else f"{method.start} {method.tolerance:g}" for method in METHODS]
    lines = [f"| pixels | log10 load | {' | '.join(names)} |", "|---|---|" + "---|" * len(METHODS)]
    for pixels, load in sorted({(one.pixels, one.log_load) for one in measured}):
        found = {one.method: one for one in measured if (one.pixels, one.log_load) == (pixels, load)}
        cells = [f"{found[m].errors['dice'].expected:.4f}, {found[m].milliseconds:.0f}" for m in METHODS]
        lines.append(f"| {pixels} | {load:.2f} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _train_command(number: int, stage: Mapping[str, Any]) -> str:
    """What trains the network, or goes on with what the stage before made."""
    start = f" --from runs/stage{number - 1}/weights" if stage["start"] else ""
    names = " ".join(f"--data {name}" for name in stage["data"])
    return (
        f"    asperity train runs/stage{number}{start} {names} \\\n"
        f"      --epochs {stage['epochs']} --learning-rate {stage['learning_rate']:g} --seed {stage['seed']}"
    )


def _build_command(name: str, dataset: dict[str, Any]) -> str:
    """The command that builds a data set again, bit for bit."""
    return (
        f"asperity dataset {name} --family {dataset['family']} --size {dataset['size']} --count {dataset['count']} "
        f"--seed {dataset['seed']}"
    )
