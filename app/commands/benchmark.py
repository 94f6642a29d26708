"""`asperity benchmark`: the measurements behind the claims of README and docs."""

import ast
import importlib.util
import runpy
import sys
from pathlib import Path
from typing import Annotated

import typer

from solver.errors import InvalidProblemError


def benchmark(
    name: Annotated[str | None, typer.Argument(help="Which; without it, the list.")] = None,
    arguments: Annotated[list[str] | None, typer.Argument(help="Of the benchmark.")] = None,
) -> None:
    """Run a benchmark, or list them; what it measures and finds is Markdown on standard output."""
    found = available()
    if name is None:
        width = max(map(len, found))
        for known, description in found.items():
            typer.echo(f"{known:<{width}}  {description.splitlines()[0]}")
        return
    if name not in found:
        raise InvalidProblemError(f"There is no benchmark {name!r}; there are {', '.join(found)}.")
    typer.echo(f"# {name.replace('-', ' ').capitalize()}\n\n{found[name]}\n")
    sys.argv[1:] = arguments or []
    runpy.run_module(f"benchmarks.{name.replace('-', '_')}", run_name="__main__", alter_sys=True)


def available() -> dict[str, str]:
    """The benchmarks with their descriptions.

    Raises:
        InvalidProblemError: Asperity was not installed from a checkout, where the benchmarks are.
    """
    spec = importlib.util.find_spec("benchmarks")
    if spec is None or spec.submodule_search_locations is None:
        raise InvalidProblemError("The benchmarks are part of the repository; install Asperity from a checkout of it.")
    modules = sorted(Path(next(iter(spec.submodule_search_locations))).glob("*.py"))
    texts = {path.stem.replace("_", "-"): path.read_text(encoding="utf-8") for path in modules}
    return {
        name: ast.get_docstring(ast.parse(text)) or ""
        for name, text in texts.items()
        if '__name__ == "__main__"' in text and name != "peer-process"
    }
