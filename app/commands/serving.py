"""`asperity serve` and `asperity worker`: the service and the processes that verify for it."""

import signal
import sys
from contextlib import ExitStack
from types import FrameType
from typing import Annotated

import typer

from app.api_key import new_key
from app.settings import read_settings
from worker.embedded_redis import EmbeddedRedis
from worker.process import run_worker
from worker.supervisor import WorkerSupervisor


def serve() -> None:
    """Serve the HTTP interface and the web page, with an embedded Redis unless REDIS_URL names one, and workers.

    Settings come from the environment: ASPERITY_HOST, ASPERITY_PORT (8000), ASPERITY_STATE_DIR, ASPERITY_WORKERS (1;
    0 for none), ASPERITY_UPLOAD_LIMIT_MIB (64), REDIS_URL and those of `asperity worker`. Ctrl-C ends all of it.
    """
    import uvicorn

    from app.main import create_app
    from app.protocol import Protocol
    from worker.logs import log_as_json
    from worker.tracing import send_traces

    settings = read_settings()
    signal.signal(signal.SIGTERM, _leave)  # uvicorn hands the signal on when it is done
    with ExitStack() as stack:
        if settings.redis_url is None:
            stack.enter_context(EmbeddedRedis(settings.state_path))
        stack.enter_context(WorkerSupervisor(settings, settings.workers))
        log_as_json()
        send_traces("asperity")
        uvicorn.run(
            create_app(settings), host=settings.host, port=settings.port, log_config=None, http=Protocol, lifespan="on"
        )


def key(name: Annotated[str, typer.Argument(help="Of the client that will use it.")]) -> None:
    """Make an API key: the secret for the client, and what ASPERITY_API_KEYS, a JSON list, must hold of it."""
    secret, known = new_key(name)
    typer.echo(f"key for {name}, shown only now: {secret}")
    typer.echo(f"ASPERITY_API_KEYS='[{known.model_dump_json(exclude_none=True)}]'")


def worker() -> None:
    """Verify predictions of the queue: that of REDIS_URL, or of a running `asperity serve` in the same state directory.

    Settings come from the environment: ASPERITY_STATE_DIR, REDIS_URL, ASPERITY_JOB_TIMEOUT_S, ASPERITY_RETENTION_DAYS.
    """
    run_worker(read_settings())


def _leave(signum: int, frame: FrameType | None) -> None:
    sys.exit(0)
