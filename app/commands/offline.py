"""`asperity dataset`, `train` and `evaluate`: the offline part of the surrogate."""

from pathlib import Path
from typing import Annotated, Any

import typer

from model.dataset import DatasetConfig, build

DATASET = DatasetConfig()
Processes = Annotated[int, typer.Option(min=1, help="How many solve side by side.")]


def dataset(
    directory: Annotated[Path, typer.Argument(file_okay=False, help="Made if it is not there; a stopped build goes on.")],
    size: Annotated[int, typer.Option(help="Pixels a side, a power of two.")] = DATASET.size,
    count: Annotated[int, typer.Option(min=1, help="Number of surfaces.")] = DATASET.count,
    seed: Annotated[int, typer.Option(help="Seed of the first surface; the others follow.")] = DATASET.seed,
    hurst: Annotated[
        tuple[float, float], typer.Option(help="Hurst exponents, uniform from lowest to highest.")
    ] = DATASET.hurst_range,
    load_n: Annotated[
        tuple[float, float], typer.Option(help="Loads in N, log-uniform from lowest to highest.")
    ] = DATASET.load_range_n,
    periodic_share: Annotated[
        float, typer.Option(min=0, max=1, help="Share of periodic surfaces.")
    ] = DATASET.periodic_share,
    instrument_share: Annotated[
        float, typer.Option(min=0, max=1, help="Share of surfaces with the form, lay and noise of measured maps.")
    ] = DATASET.instrument_share,
    side_mm: Annotated[float, typer.Option(help="Side of the square, in mm.")] = DATASET.side_mm,
    height_range_um: Annotated[
        float, typer.Option(help="Lowest to highest height, in micrometres.")
    ] = DATASET.height_range_um,
    effective_modulus_gpa: Annotated[
        float, typer.Option(help="Effective modulus E*, in GPa.")
    ] = DATASET.effective_modulus_gpa,
    tolerance: Annotated[float, typer.Option(help="Residual at which a solve ends.")] = DATASET.tolerance,
    processes: Processes = 1,
    device: Annotated[
        str | None, typer.Option(show_default="the processor", help="Device of torch to solve on, such as cuda.")
    ] = None,
) -> None:
    """Build random midpoint surfaces (16-bit PNG), solve them, and store masks (1-bit PNG) and units."""
    config = DatasetConfig(
        size=size,
        count=count,
        seed=seed,
        hurst_range=hurst,
        load_range_n=load_n,
        periodic_share=periodic_share,
        instrument_share=instrument_share,
        side_mm=side_mm,
        height_range_um=height_range_um,
        effective_modulus_gpa=effective_modulus_gpa,
        tolerance=tolerance,
    )
    build(directory, config, processes, device)


def train(
    directory: Annotated[Path, typer.Argument(file_okay=False, help="Of the run; a stopped run goes on.")],
    data: Annotated[
        list[Path], typer.Option(exists=True, file_okay=False, help="Data set made by `asperity dataset`; may be repeated.")
    ],
    width: Annotated[
        int | None, typer.Option(show_default="16", help="Feature maps of the first stage; the paper's is 64.")
    ] = None,
    alpha: Annotated[float | None, typer.Option(show_default="0.5", help="Weight of the BCE against the Dice loss.")] = None,
    batch: Annotated[int | None, typer.Option(show_default="32", help="Maps a step.")] = None,
    learning_rate: Annotated[float | None, typer.Option(show_default="0.001", help="Of Adam, at the start.")] = None,
    epochs: Annotated[int | None, typer.Option(show_default="100", help="At most.")] = None,
    seed: Annotated[int | None, typer.Option(show_default="0", help="Of weights, order and rotations.")] = None,
    threads: Annotated[int | None, typer.Option(show_default="2", help="Of torch on the CPU.")] = None,
) -> None:
    """Train the U-Net on a data set."""
    from model.train import TrainConfig
    from model.train import train as train_network

    given: dict[str, Any] = {
        "width": width,
        "alpha": alpha,
        "batch": batch,
        "learning_rate": learning_rate,
        "epochs": epochs,
        "seed": seed,
        "threads": threads,
    }
    config = TrainConfig(data=tuple(map(str, data)), **{name: value for name, value in given.items() if value is not None})
    train_network(directory, config)


def evaluate(
    data: Annotated[Path, typer.Option(file_okay=False, help="Directory of the test sets, built where missing.")],
    report: Annotated[Path, typer.Option(dir_okay=False, help="Model card to write, Markdown.")],
    weights: Annotated[
        Path | None, typer.Option(file_okay=False, show_default="the shipped ones", help="Directory of the weights.")
    ] = None,
    count: Annotated[int, typer.Option(min=1, help="Maps a size.")] = 200,
    processes: Processes = 1,
) -> None:
    """Evaluate the surrogate on surfaces it never saw, 32 x 32 to 512 x 512, and write its model card."""
    from model.evaluate import evaluate as evaluate_weights
    from model.evaluate import table

    typer.echo(table(evaluate_weights(data, report, weights, count=count, processes=processes)))
