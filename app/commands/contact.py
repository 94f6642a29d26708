"""`asperity predict` and `asperity solve`: one height map on the command line, with the option names of HTTP."""

import inspect
import json
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any, cast

import numpy as np
import typer
from tqdm import tqdm

from app.forms import ProblemForm, parse_accuracy
from app.reading import Files, Reading, read_problem
from app.uploads import decode
from solver import ContactProblem, Solution, boyer_resistance
from solver import solve as solve_contact
from solver.operators import Method
from worker.masks import mask_png
from worker.statistics import resistances, statistics

HeightMapFile = Annotated[
    Path,
    typer.Argument(
        exists=True,
        dir_okay=False,
        metavar="FILE",
        help="Grey PNG or TIFF, NPY, CSV, or an instrument's file.",
    ),
]
SecondFile = Annotated[
    Path | None,
    typer.Option("--surface-2", exists=True, dir_okay=False, help="Height map of the other surface, if not a flat."),
]
MaskFile = Annotated[Path | None, typer.Option("--mask", dir_okay=False, help="Write the mask here, as a 1-bit PNG.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Command = Callable[..., None]


def with_problem_options(command: Command) -> Command:
    """Put an option for each field of the problem form in the place of a command's ``**fields``."""
    signature = inspect.signature(command)
    own = [parameter for parameter in signature.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD]
    options = [
        inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=None,
            annotation=Annotated[str | None, typer.Option(help=_sentence(field.description), metavar="VALUE")],
        )
        for name, field in ProblemForm.model_fields.items()
    ]
    parameters = [*own, *options]
    command.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return command


def _sentence(description: str | None) -> str:
    text = description or ""
    return f"{text[:1].upper()}{text[1:]}."


def parse_form(fields: dict[str, Any]) -> ProblemForm:
    """The problem form of a command's options."""
    return ProblemForm.parse({name: value for name, value in fields.items() if value is not None})


def read_files(file: Path, surface_2: Path | None, form: ProblemForm) -> Reading:
    """The problem of a command's files and options."""
    files = Files(file.read_bytes(), surface_2.read_bytes() if surface_2 else None)
    return read_problem(files, form, form.load_n, decode)


@with_problem_options
def predict(
    file: HeightMapFile,
    surface_2: SecondFile = None,
    mask: MaskFile = None,
    as_json: AsJson = False,
    accuracy: Annotated[
        str,
        typer.Option(
            help="fast, balanced, exact, or the mean error that is allowed of mask, area and resistance, from 0 to 1."
        ),
    ] = "balanced",
    attribution: Annotated[
        Path | None, typer.Option(dir_okay=False, help="Write here, as NPY, which heights moved the network's answer.")
    ] = None,
    **fields: str | None,
) -> None:
    """Predict where a height map touches a flat under a load: mask, contact area, contact resistance."""
    from app.prediction import Stopwatch, Wanted
    from app.prediction import predict as predict_contact
    from model import Surrogate

    form, surrogate = parse_form(fields), Surrogate.load()
    stopwatch = Stopwatch()
    reading = read_files(file, surface_2, form)
    stopwatch.lap("decode")
    wanted = Wanted(parse_accuracy(accuracy), form.resistivity_ohm_m)
    predicted = predict_contact(reading, wanted, surrogate, stopwatch)
    if attribution:
        from model.attribution import attribution as attribute

        np.save(attribution, attribute(surrogate, reading.problem))
    numbers = predicted.numbers
    if mask:
        mask.write_bytes(mask_png(predicted.prediction.contact_mask))
    if as_json:
        typer.echo(numbers.model_dump_json(indent=2))
        return
    surface, expected = numbers.surface, numbers.expected_error
    resistance = numbers.contact_resistance_ohm
    print_table(
        {
            "read": f"{surface.rows} rows x {surface.columns} columns, rms height {surface.rms_height_um:.4g} um, "
            f"rms slope {surface.rms_slope:.3g}",
            "method": f"{numbers.method}, {numbers.model}",
            "contact area": f"{numbers.contact_area_mm2:.6g} mm2, expected error {expected.contact_area:.2%}, "
            f"nine in ten below {expected.contact_area_bound:.2%}",
            "contact fraction": f"{numbers.contact_fraction:.4%}",
            "contact resistance": "no resistivity given"
            if resistance is None
            else f"{resistance:.6g} ohm, expected error {expected.contact_resistance:.2%}",
            "expected Dice": f"{1 - expected.dice:.4f}",
            "time": f"{numbers.timings_ms['total']:.0f} ms",
        }
    )
    for warning in numbers.warnings:
        typer.echo(f"warning: {warning}", err=True)


@with_problem_options
def solve(
    file: HeightMapFile,
    surface_2: SecondFile = None,
    mask: MaskFile = None,
    as_json: AsJson = False,
    tolerance: Annotated[float, typer.Option(help="Residual at which the solve ends, dimensionless.")] = 1e-6,
    method: Annotated[str, typer.Option(help="How displacements are evaluated: fft or multilevel (free boundary).")] = "fft",
    **fields: str | None,
) -> None:
    """Solve the contact of a height map numerically; exit code 1 if the solve does not converge."""
    form = parse_form(fields)
    problem = read_files(file, surface_2, form).problem
    started = perf_counter()
    with tqdm(desc="solve", unit=" iterations") as bar:

        def show(iteration: int, residual: float) -> None:
            bar.set_postfix(residual=f"{residual:.1e}", refresh=False)
            bar.update(iteration - bar.n)

        solution = solve_contact(problem, cast(Method, method), tolerance, on_iteration=show)
    seconds = perf_counter() - started
    answer = {
        "status": solution.status.value,
        "converged": solution.converged,
        "residual": solution.residual,
        "iterations": solution.iterations,
        "solve_seconds": seconds,
    } | contact_numbers(problem, solution, form.resistivity_ohm_m)
    if mask:
        mask.write_bytes(mask_png(solution.contact_mask))
    if as_json:
        typer.echo(json.dumps(answer, indent=2))
    else:
        print_table({name: f"{value:.6g}" if isinstance(value, float) else str(value) for name, value in answer.items()})
    if not solution.converged:
        raise typer.Exit(1)


def contact_numbers(problem: ContactProblem, solution: Solution, resistivity: float | None) -> dict[str, Any]:
    """What a solution says of the contact, units in the names; resistances if a resistivity is given."""
    found = {"contact_area_mm2": solution.contact_fraction * problem.nominal_area * 1e6}
    found |= {"contact_fraction": solution.contact_fraction} | statistics(problem, solution).model_dump()
    if resistivity is None:
        return found
    resistance = boyer_resistance(solution.contact_mask, problem.pixel_size, resistivity)
    return found | {"contact_resistance_ohm": resistance} | resistances(problem, solution, resistivity).model_dump()


def print_table(rows: dict[str, str]) -> None:
    """Names and values in two columns."""
    width = max(map(len, rows))
    for name, value in rows.items():
        typer.echo(f"{name:<{width}}  {value}")
