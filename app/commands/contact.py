"""`asperity predict` and `asperity solve`: one height map on the command line, with the option names of HTTP."""

import inspect
import json
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import typer
from tqdm import tqdm

from app.forms import ProblemForm
from app.uploads import decode_png
from solver import boyer_resistance
from solver import solve as solve_contact
from worker.masks import mask_png

HeightMapFile = Annotated[
    Path, typer.Argument(exists=True, dir_okay=False, metavar="FILE", help="8- or 16-bit grey PNG, white is highest.")
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


@with_problem_options
def predict(file: HeightMapFile, mask: MaskFile = None, as_json: AsJson = False, **fields: str | None) -> None:
    """Predict where a height map touches a flat under a load: mask, contact area, contact resistance."""
    from app.prediction import Stopwatch
    from app.prediction import predict as predict_contact
    from model import Surrogate

    form = parse_form(fields)
    predicted = predict_contact(file.read_bytes(), form, Surrogate.load(), Stopwatch())
    numbers = predicted.numbers
    if mask:
        mask.write_bytes(mask_png(predicted.mask))
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
            "contact area": f"{numbers.contact_area_mm2:.6g} mm2, expected error {expected.contact_area:.2%}",
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
    mask: MaskFile = None,
    as_json: AsJson = False,
    tolerance: Annotated[float, typer.Option(help="Residual at which the solve ends, dimensionless.")] = 1e-6,
    **fields: str | None,
) -> None:
    """Solve the contact of a height map numerically; exit code 1 if the solve does not converge."""
    form = parse_form(fields)
    problem = form.problem(decode_png(file.read_bytes()))
    started = perf_counter()
    with tqdm(desc="solve", unit=" iterations") as bar:

        def show(iteration: int, residual: float) -> None:
            bar.set_postfix(residual=f"{residual:.1e}", refresh=False)
            bar.update(iteration - bar.n)

        solution = solve_contact(problem, tolerance=tolerance, on_iteration=show)
    contact = solution.contact_mask
    answer = {
        "status": solution.status.value,
        "converged": solution.converged,
        "residual": solution.residual,
        "iterations": solution.iterations,
        "contact_area_mm2": float(contact.sum()) * problem.pixel_area * 1e6,
        "contact_fraction": solution.contact_fraction,
        "contact_resistance_ohm": None
        if form.resistivity_ohm_m is None
        else boyer_resistance(contact, problem.pixel_size, form.resistivity_ohm_m),
        "approach_um": solution.approach * 1e6,
        "highest_pressure_gpa": float(solution.pressure.max()) * 1e-9,
        "solve_seconds": perf_counter() - started,
    }
    if mask:
        mask.write_bytes(mask_png(contact))
    if as_json:
        typer.echo(json.dumps(answer, indent=2))
    else:
        print_table({name: f"{value:.6g}" if isinstance(value, float) else str(value) for name, value in answer.items()})
    if not solution.converged:
        raise typer.Exit(1)


def print_table(rows: dict[str, str]) -> None:
    """Names and values in two columns."""
    width = max(map(len, rows))
    for name, value in rows.items():
        typer.echo(f"{name:<{width}}  {value}")
