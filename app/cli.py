"""The command line, installed as ``asperity``.

Exit codes: 0, 1 for a failure (a solve that does not converge, a service that fails), 2 for bad input.
Commands import torch only where they need it: it takes seconds, and the worker must not have it.
"""

import re
import sys

import typer

from app.commands.benchmark import benchmark
from app.commands.contact import predict, solve
from app.commands.offline import dataset, evaluate, train
from app.commands.serving import key, serve, worker
from app.forms import ProblemForm
from solver.errors import AsperityError, NotConvergedError

cli = typer.Typer(
    help="Contact of rough surfaces: predict, solve, serve.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (serve, worker, key, predict, solve, dataset, train, evaluate, benchmark):
    cli.command()(command)

FIELD_NAME = re.compile(rf"\b({'|'.join(name for name in ProblemForm.model_fields if '_' in name)})\b")


def main() -> None:
    """Run the command line; typed errors become one line and an exit code."""
    try:
        cli()
    except AsperityError as error:
        typer.echo(f"asperity: {as_options(str(error))}", err=True)
        failed = isinstance(error, NotConvergedError) or error.http_status >= 500
        sys.exit(1 if failed else 2)


def as_options(message: str) -> str:
    """A message that names fields of the form, naming options instead."""
    return FIELD_NAME.sub(lambda match: "--" + match[0].replace("_", "-"), message)
