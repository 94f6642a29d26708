"""What the endpoints share: surrogate, store, queue, decoder, and threads to compute in."""

from collections.abc import AsyncIterator, Callable, Iterator
from typing import TypeVar

from anyio import CapacityLimiter, to_thread

from app.errors import BusyError
from app.metrics import Metrics
from app.sandbox import Sandbox
from app.schemas import (
    ModelAnswer,
)
from app.settings import Settings
from model import Surrogate
from model.errors import WeightsError
from model.weights import NAME
from worker.connection import connect
from worker.jobs import VerificationQueue
from worker.store import ResultStore

Item = TypeVar("Item")
Result = TypeVar("Result")

PREDICTIONS_AT_ONCE = 2
"""More would only share the processors, and memory is what large maps need most."""


class Service:
    """Surrogate, store and queue behind the HTTP interface.

    Without weights it starts all the same: every use of the surrogate then says what is missing.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.store = ResultStore(settings.results_place, settings.retention_s)
        self.metrics = Metrics(self.queue)
        self._limiter = CapacityLimiter(PREDICTIONS_AT_ONCE)
        self.sandbox = Sandbox()
        self._surrogate: Surrogate | WeightsError = WeightsError("The service has not started yet.")

    def start(self) -> None:
        """Load the network, and have the readers of files imported meanwhile."""
        self.sandbox.start()
        try:
            self._surrogate = Surrogate.load()
        except WeightsError as error:
            self._surrogate = error

    @property
    def surrogate(self) -> Surrogate:
        """The surrogate.

        Raises:
            WeightsError: its weights are missing or damaged.
        """
        if isinstance(self._surrogate, WeightsError):
            raise self._surrogate
        return self._surrogate

    def check(self) -> None:
        """Make sure that predictions and verifications are possible.

        Raises:
            WeightsError, QueueUnavailableError: the cause why they are not.
        """
        _ = self.surrogate
        self.queue()

    def queue(self) -> VerificationQueue:
        """The queue, over a connection that has just answered: a Redis that restarts is found again."""
        return VerificationQueue(connect(self.settings), self.settings)

    def model(self) -> ModelAnswer:
        """The surrogate: what it was trained on and how wrong it was found to be.

        Raises:
            WeightsError: its weights are missing or damaged.
        """
        weights = self.surrogate.weights
        return ModelAnswer(
            name=NAME,
            version=weights.version,
            sha256=weights.manifest["sha256"],
            domain=weights.manifest["domain"],
            measured_error=weights.manifest["validation"],
        )

    async def one_by_one(self, items: Iterator[Item]) -> AsyncIterator[Item]:
        """Each computed away from the event loop, so that other requests come in between."""
        while (item := await self.in_thread(next, items, None)) is not None:
            yield item

    async def in_thread(self, function: Callable[..., Result], *args: object) -> Result:
        """Compute away from the event loop, a few requests at a time.

        Raises:
            BusyError: too many wait.
        """
        waiting = self._limiter.statistics().tasks_waiting
        if waiting >= self.settings.requests_waiting:
            raise BusyError(f"{waiting} requests wait to be computed; try again later.")
        return await to_thread.run_sync(function, *args, limiter=self._limiter)
