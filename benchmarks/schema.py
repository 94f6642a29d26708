"""Schemathesis against a running service: requests made from /openapi.json, valid and not, alone and one after the other.

    asperity benchmark schema [EXAMPLES]

All checks but one: that what fits the schema is accepted. OpenAPI cannot say that a form needs one of two sets of fields, or
that a file is a picture. Half of the forms get a real height map and what they lack.
"""

import os
import subprocess
import sys
import zlib
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import schemathesis

from benchmarks.service import midpoint_upload, service

SURFACE, FIELDS = midpoint_upload(32, 30.0)
WORKERS = 2
EXCLUDED = "positive_data_acceptance"


def main() -> None:
    """Print the summary."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    with service(ASPERITY_QUEUE_LENGTH="100000") as (client, _):
        done = explored(str(client.base_url), count)
        alive = client.get("/readyz").status_code
    print(done.stdout[done.stdout.rindex("API Operations:") :].strip())
    print(f"\n/readyz afterwards: {alive}")


def explored(url: str, count: int) -> "subprocess.CompletedProcess[str]":
    """Schemathesis, with so many examples for each operation and phase."""
    options = {"--max-examples": count, "--workers": WORKERS, "--request-timeout": 60, "--exclude-checks": EXCLUDED}
    arguments = [str(part) for option in options.items() for part in option]
    program = Path(sys.executable).with_name("schemathesis")
    root = str(Path(__file__).parent.parent)
    environment = os.environ | {"SCHEMATHESIS_HOOKS": "benchmarks.schema", "PYTHONPATH": root}
    command = [str(program), "run", f"{url}/openapi.json", "--no-color", *arguments]
    with TemporaryDirectory() as place:  # for what it remembers
        return subprocess.run(command, env=environment, cwd=place, capture_output=True, text=True, check=False)


@schemathesis.hook
def map_body(context: schemathesis.HookContext, body: Any) -> Any:
    """Half of the forms that have a file get a good one, and the fields that it needs where they are not there."""
    if not isinstance(body, dict) or not isinstance(body.get("surface"), bytes) or zlib.crc32(repr(body).encode()) % 2:
        return body
    needed = {name: value for name, value in FIELDS.items() if name != "load_n"}
    return needed | {name: value for name, value in body.items() if name != "surface_2"} | {"surface": SURFACE}


if __name__ == "__main__":
    main()
