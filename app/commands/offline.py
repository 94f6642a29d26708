"""`asperity dataset`, `train` and `evaluate`: the offline part of the surrogate."""

from pathlib import Path
from typing import Annotated, Any

import typer

from app.settings import read_settings
from model.dataset import DatasetConfig, build, export, fill
from model.families import Family, Units
from worker.connection import connect
from worker.shards import ShardQueue

DATASET = DatasetConfig()
Processes = Annotated[int, typer.Option(min=1, help="How many solve side by side.")]


def dataset(
    directory: Annotated[Path, typer.Argument(file_okay=False, help="Made if it is not there; a stopped build goes on.")],
    size: Annotated[int, typer.Option(help="Pixels a side, a power of two.")] = DATASET.size,
    count: Annotated[int, typer.Option(min=1, help="Number of surfaces.")] = DATASET.count,
    seed: Annotated[int, typer.Option(help="Seed of the first surface; the others follow.")] = DATASET.seed,
    family: Annotated[
        Family, typer.Option(help="The paper's random midpoint surfaces, spectral ones of one kind, or varied ones.")
    ] = DATASET.family,
    hurst: Annotated[
        tuple[float, float], typer.Option(help="Hurst exponents, uniform from lowest to highest; not of varied surfaces.")
    ] = DATASET.hurst_range,
    load_n: Annotated[
        tuple[float, float], typer.Option(help="Loads in N, log-uniform from lowest to highest; not on varied surfaces.")
    ] = DATASET.load_range_n,
    side_mm: Annotated[float, typer.Option(help="Side of the square, in mm.")] = DATASET.units.side_mm,
    height_range_um: Annotated[
        float, typer.Option(help="Lowest to highest height, in micrometres.")
    ] = DATASET.units.height_range_um,
    effective_modulus_gpa: Annotated[
        float, typer.Option(help="Effective modulus E*, in GPa.")
    ] = DATASET.units.effective_modulus_gpa,
    tolerance: Annotated[float, typer.Option(help="Residual at which a solve ends.")] = DATASET.tolerance,
    processes: Processes = 1,
    device: Annotated[
        str | None, typer.Option(show_default="the processor", help="Device of torch to solve on, such as cuda.")
    ] = None,
    queue: Annotated[
        bool, typer.Option("--queue", help="Have it built by the workers (`asperity worker`) of REDIS_URL.")
    ] = False,
    png: Annotated[
        bool, typer.Option("--png", help="Write the height maps as 16-bit PNG too, with their units in samples.jsonl.")
    ] = False,
) -> None:
    """Build rough surfaces and solve them; heights and pressures go into shards with a hash each."""
    config = DatasetConfig(
        size=size,
        count=count,
        seed=seed,
        family=family,
        hurst_range=hurst,
        load_range_n=load_n,
        units=Units(side_mm, height_range_um, effective_modulus_gpa),
        tolerance=tolerance,
    )
    if queue:
        settings = read_settings()
        fill(directory, config, ShardQueue(connect(settings), settings))
    else:
        build(directory, config, processes, device)
    if png:
        export(directory)


def train(
    directory: Annotated[Path, typer.Argument(file_okay=False, help="Of the run; a stopped run goes on.")],
    data: Annotated[
        list[Path], typer.Option(exists=True, file_okay=False, help="Data set made by `asperity dataset`; may be repeated.")
    ],
    epochs: Annotated[int | None, typer.Option(show_default="8", help="Times that every map is seen.")] = None,
    learning_rate: Annotated[float | None, typer.Option(show_default="0.002", help="At its highest.")] = None,
    seed: Annotated[int | None, typer.Option(show_default="0", help="Of weights, order and rotations.")] = None,
    start: Annotated[
        Path | None,
        typer.Option("--from", exists=True, file_okay=False, show_default="none", help="Weights to start from."),
    ] = None,
    processes: Processes = 1,
) -> None:
    """Train the network on data sets, on all cores or on a GPU."""
    from model.train import TrainConfig
    from model.train import train as train_network

    given: dict[str, Any] = {
        "epochs": epochs,
        "learning_rate": learning_rate,
        "seed": seed,
        "start": None if start is None else str(start),
    }
    config = TrainConfig(data=tuple(map(str, data)), **{name: value for name, value in given.items() if value is not None})
    train_network(directory, config, processes)


def evaluate(
    data: Annotated[Path, typer.Option(file_okay=False, help="Directory of the test sets, built where missing.")],
    report: Annotated[Path, typer.Option(dir_okay=False, help="Model card to write, Markdown.")],
    weights: Annotated[
        Path | None, typer.Option(file_okay=False, show_default="the shipped ones", help="Directory of the weights.")
    ] = None,
    count: Annotated[int, typer.Option(min=1, help="Maps of a test set of 128 x 128.")] = 100,
    processes: Processes = 1,
) -> None:
    """Evaluate the surrogate on surfaces it never saw, and write its model card."""
    from model.evaluate import evaluate as evaluate_weights
    from model.model_card import table
    from model.weights import SHIPPED

    for name, rows in evaluate_weights(data, report, weights or SHIPPED, count, processes).items():
        typer.echo(f"{name}\n\n{table(rows)}")
