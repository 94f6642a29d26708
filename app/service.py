"""What the endpoints share: store, queue, decoder, and processes to compute in."""

import asyncio
import logging
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from anyio import CapacityLimiter, to_thread

from app.batching import Batching
from app.compute import Compute
from app.metrics import Metrics
from app.sandbox import Sandbox
from app.schemas import (
    ModelAnswer,
)
from app.settings import Settings
from model.weights import NAME, SHIPPED, read_manifest, version
from solver.errors import AsperityError
from worker.connection import connect
from worker.jobs import VerificationQueue
from worker.store import ResultStore

Result = TypeVar("Result")

logger = logging.getLogger(__name__)

THREADS = 32
"""That wait for files, the queue or a decoder."""


class Service:
    """Store, queue and processes that compute, behind the HTTP interface.

    Without weights it starts all the same: whatever needs them then says what is missing.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.store = ResultStore(settings.results_place, settings.retention_s)
        self.metrics = Metrics(self.queue)
        self.sandbox = Sandbox()
        self.compute = Compute(settings)
        self.batching = Batching(self.compute)
        self._background: set[asyncio.Task[Any]] = set()
        self._limiter = CapacityLimiter(THREADS)

    async def start(self) -> None:
        """Start what computes and what decodes."""
        self.sandbox.start()
        await self.compute.start()

    async def stop(self) -> None:
        """Let what is computed be ended, and end it."""
        await asyncio.gather(*self._background, return_exceptions=True)
        await asyncio.to_thread(self.compute.stop)

    @property
    def version(self) -> str:
        """Name and start of the hash of the weights.

        Raises:
            WeightsError: there are none.
        """
        return version(read_manifest(self.settings.weights or SHIPPED))

    async def check(self) -> str:
        """Make sure that predictions and verifications are possible; returns the version of the weights.

        Raises:
            WeightsError, ComputeError, QueueUnavailableError: the cause why they are not.
        """
        found = self.compute.check()
        await to_thread.run_sync(self.queue)
        return found

    def queue(self) -> VerificationQueue:
        """The queue, over a connection that has just answered: a Redis that restarts is found again."""
        return VerificationQueue(connect(self.settings), self.settings)

    def model(self) -> ModelAnswer:
        """The surrogate: what it was trained on and how wrong it was found to be.

        Raises:
            WeightsError: its weights are missing or damaged.
        """
        manifest = read_manifest(self.settings.weights or SHIPPED)
        return ModelAnswer(
            name=NAME,
            version=version(manifest),
            sha256=manifest["sha256"],
            domain=manifest["domain"],
            measured_error=manifest["validation"],
        )

    @property
    def in_background(self) -> int:
        """Requests that were answered and are gone on with."""
        return len(self._background)

    def go_on(self, work: Coroutine[None, None, Result]) -> asyncio.Task[Result]:
        """Go on with a request that may be answered before."""
        task = asyncio.create_task(work)
        self._background.add(task)
        task.add_done_callback(self._forget)
        return task

    def _forget(self, task: asyncio.Task[Any]) -> None:
        self._background.discard(task)
        if not task.cancelled() and (error := task.exception()) and not isinstance(error, AsperityError):
            logger.error("What went on in the background failed", exc_info=error)

    async def in_thread(self, function: Callable[..., Result], *arguments: object) -> Result:
        """Do what waits for files, the queue or a decoder away from the event loop."""
        return await to_thread.run_sync(function, *arguments, limiter=self._limiter)
