"""Runs one peer in a process of its own: it may hang or crash, and slippy has an environment of its own.

As a script, it reads names of files with problems, one a line, and answers each with a file of the same name plus ``.out``.
"""

import importlib.util
import json
import select
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from solver import ContactProblem

SLIPPY = Path(".venv-slippy/bin/python")


@dataclass(frozen=True)
class Outcome:
    """What became of a call.

    Attributes:
        kind: ``answered``, ``raised``, ``not supported``, ``hung`` or ``crashed``.
        message: of what was raised.
        pressure: in Pa, if answered.
        converged: whether the peer says so.
        seconds: in its process, best of the repeats.
    """

    kind: str
    message: str = ""
    pressure: np.ndarray | None = None
    converged: bool = False
    seconds: float = np.inf


class PeerProcess:
    """A peer, started when it is first asked and again after it hung or crashed.

    Args:
        name: in ``peer_solvers.PEERS``.
        limit: seconds after which a call counts as hung.
    """

    def __init__(self, name: str, limit: float) -> None:
        self.name = name
        self.limit = limit
        self._process: subprocess.Popen[str] | None = None
        self._directory = tempfile.TemporaryDirectory()

    @property
    def python(self) -> str:
        """The interpreter of the peer's environment."""
        return str(SLIPPY) if self.name == "slippy" else sys.executable

    @property
    def installed(self) -> bool:
        """Whether the peer can be run."""
        if self.name == "slippy":
            return SLIPPY.exists()
        package = self.name.split(",")[0]
        return importlib.util.find_spec({"Tamaas": "tamaas"}.get(package, package)) is not None

    def solve(self, problem: "ContactProblem", tolerance: float, repeats: int = 1) -> Outcome:
        """Solve a problem."""
        return self(
            repeats,
            heights=problem.heights,
            pixel_size=problem.pixel_size,
            load=problem.load,
            effective_modulus=problem.effective_modulus,
            boundary=problem.boundary,
            tolerance=tolerance,
        )

    def __call__(self, repeats: int = 1, **given: object) -> Outcome:
        """Run it on the fields of :class:`benchmarks.peer_solvers.Given`, a few times for the best time."""
        if self._process is None or self._process.poll() is not None:
            command = [self.python, str(Path(__file__)), self.name]
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
            )
            assert self._process.stdout is not None
            self._process.stdout.readline()
        path = Path(self._directory.name) / "given.npz"
        np.savez(path, repeats=repeats, **given)  # type: ignore[arg-type]
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{path}\n")
        self._process.stdin.flush()
        ready, _, _ = select.select([self._process.stdout], [], [], self.limit)
        line = self._process.stdout.readline() if ready else ""
        if not line:
            self.close()
            return Outcome("crashed" if ready else "hung")
        said = json.loads(line)
        pressure = np.load(f"{path}.npy") if said["kind"] == "answered" else None
        return Outcome(pressure=pressure, **said)

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


def _serve(name: str) -> None:
    from peer_solvers import PEERS, Given, NotSupportedError

    answers = sys.stdout
    sys.stdout = sys.stderr
    print("ready", file=answers, flush=True)
    for line in sys.stdin:
        path = line.strip()
        with np.load(path) as stored:
            fields = {key: stored[key] for key in stored.files}
        repeats = int(fields.pop("repeats"))
        said: dict[str, object]
        try:
            given = Given(
                heights=fields["heights"],
                pixel_size=tuple(map(float, fields["pixel_size"])),  # type: ignore[arg-type]
                load=float(fields["load"]),
                effective_modulus=float(fields["effective_modulus"]),
                boundary=str(fields["boundary"]),
                tolerance=float(fields["tolerance"]),
            )
            times: list[float] = []
            while len(times) < repeats and sum(times) < 10:
                started = time.perf_counter()
                pressure, converged = PEERS[name](given)  # type: ignore[operator]
                times.append(time.perf_counter() - started)
            np.save(f"{path}.npy", pressure)
            said = {"kind": "answered", "converged": bool(converged), "seconds": min(times)}
        except NotSupportedError as error:
            said = {"kind": "not supported", "message": str(error)}
        except Exception as error:  # noqa: BLE001 - whatever a peer raises is its answer
            said = {"kind": "raised", "message": f"{type(error).__name__}: {error}"[:200]}
        print(json.dumps(said), file=answers, flush=True)


if __name__ == "__main__":
    _serve(sys.argv[1])
