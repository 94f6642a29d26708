"""Processes that compute, so that the event loop only ever waits: each holds a network, a store and a queue of its own."""

import asyncio
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from typing import Any, TypeVar

from app.errors import BusyError, ComputeError
from app.settings import Settings
from model import Surrogate
from model.weights import SHIPPED
from worker.connection import connect
from worker.jobs import VerificationQueue
from worker.lifetime import die_with_parent
from worker.logs import log_as_json, request_id
from worker.store import ResultStore
from worker.tracing import Carrier, carrier, send_traces, span

Result = TypeVar("Result")

NICE = 5


class Computer:
    """What one of the processes computes with.

    Raises:
        WeightsError: the weights are missing or damaged.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.surrogate = Surrogate.load(settings.weights or SHIPPED)
        self.store = ResultStore(settings.results_place, settings.retention_s)

    def queue(self) -> VerificationQueue:
        """The queue, over a connection that has just answered.

        Raises:
            QueueUnavailableError: nothing answers.
        """
        return VerificationQueue(connect(self.settings), self.settings)


class Compute:
    """The processes. If one dies all are replaced, and what they computed is computed again, once.

    Args:
        settings: handed on to the processes.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._waiting = 0
        self._found: str | BaseException = ComputeError("The service has not started yet.")
        self._pool: ProcessPoolExecutor | None = None

    async def start(self) -> None:
        """Start the processes, and wait until they have tried to load the network."""
        self._start()
        each = [self.run(_ready) for _ in range(self.settings.compute_processes)]
        self._found = (await asyncio.gather(*each, return_exceptions=True))[0]

    def check(self) -> str:
        """The version of the weights that the processes predict with.

        Raises:
            ComputeError, WeightsError: why they do not.
        """
        if isinstance(self._found, BaseException):
            raise self._found
        return self._found

    def stop(self) -> None:
        """Let the processes end what they compute, and end them."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)

    async def run(self, task: Callable[..., Result], *arguments: object) -> Result:
        """Compute in one of the processes.

        Args:
            task: a function of a module, called with the computer of the process and the arguments.
            arguments: all that it needs besides.

        Raises:
            BusyError: too many tasks wait.
            ComputeError: the processes die of this task.
            AsperityError: what the task raises.
        """
        with self.admitted():
            return await self.submit(task, *arguments)

    @contextmanager
    def admitted(self) -> Iterator[None]:
        """Within it a request waits to be computed.

        Raises:
            BusyError: too many do.
        """
        if self._waiting >= self.settings.requests_waiting:
            raise BusyError(f"{self._waiting} requests wait to be computed; try again later.")
        self._waiting += 1
        try:
            yield
        finally:
            self._waiting -= 1

    async def submit(self, task: Callable[..., Result], *arguments: object) -> Result:
        """As :meth:`run`, for requests that were admitted before."""
        for _ in range(2):
            with suppress(BrokenProcessPool):
                return await self.once(task, *arguments)
        raise ComputeError("The process that computed this died twice, perhaps for want of memory.")

    async def once(self, task: Callable[..., Result], *arguments: object) -> Result:
        """As :meth:`submit`, not tried again.

        Raises:
            BrokenProcessPool: the process died; there are new ones.
        """
        pool = self._pool
        if pool is None:
            raise ComputeError("The service has not started yet.")
        try:
            return await asyncio.wrap_future(pool.submit(_call, request_id.get(), carrier(), task, arguments))
        except BrokenProcessPool:
            if self._pool is pool:  # nobody else has replaced it yet
                self._start()
            raise

    def _start(self) -> None:
        self._pool = ProcessPoolExecutor(
            self.settings.compute_processes,
            mp_context=get_context("spawn"),
            initializer=_prepare,
            initargs=(os.getpid(), self.settings),
        )


def _ready(computer: Computer) -> str:
    return computer.surrogate.version


_here: dict[str, Any] = {}
"""What this process was started with, and its computer once something was asked of it."""


def _prepare(parent: int, settings: Settings) -> None:
    """The start of a process, which yields to the one with the event loop."""
    die_with_parent(parent)
    os.nice(NICE)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes; what is computed is to be answered
    log_as_json()
    send_traces("asperity-compute")
    _here["settings"] = settings


def _call(request: str | None, place: Carrier, task: Callable[..., Result], arguments: tuple[object, ...]) -> Result:
    """A task, in the process; weights that cannot be loaded are told to whoever asks for something."""
    if "computer" not in _here:
        _here["computer"] = Computer(_here["settings"])
    request_id.set(request)
    with span(task.__name__, place):
        return task(_here["computer"], *arguments)
