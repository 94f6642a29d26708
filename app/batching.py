"""Predictions that wait for a process are computed together: the network takes two thirds of the time for many maps at once.

Nothing waits for others to come: what has gathered while the processes were busy makes a batch.
"""

import asyncio
from collections.abc import Hashable
from concurrent.futures.process import BrokenProcessPool
from math import ceil

from app.compute import Compute
from app.computing import Item, computed_predictions
from app.schemas import PredictionAnswer

MOST = 8
"""Items of a batch."""

LARGEST_PIXELS = 2**16
"""Of a map; the network gains nothing from larger ones together."""

Waiting = tuple[Item, "asyncio.Future[PredictionAnswer]"]


class Batching:
    """Gathers predictions of maps of one shape and accuracy.

    Args:
        compute: the processes.
    """

    def __init__(self, compute: Compute) -> None:
        self._compute = compute
        self._processes = self._free = compute.settings.compute_processes
        self._running: set[asyncio.Task[None]] = set()
        self._groups: dict[Hashable, list[Waiting]] = {}

    async def predict(self, item: Item) -> PredictionAnswer:
        """The answer to one of the predictions.

        Raises:
            AsperityError: what :meth:`app.compute.Compute.run` or the prediction raises.
        """
        answer: asyncio.Future[PredictionAnswer] = asyncio.get_running_loop().create_future()
        shape = item.maps.shape
        alone = shape is None or shape[0] * shape[1] > LARGEST_PIXELS or item.form.resample_um is not None
        key = item.prediction_id if alone else (shape, item.form.accuracy)
        with self._compute.admitted():
            self._groups.setdefault(key, []).append((item, answer))
            self._start()
            return await answer

    def _start(self) -> None:
        """Hand a batch to each free process, the longest waiting first."""
        while self._free and self._groups:
            key, group = next(iter(self._groups.items()))
            count = min(MOST, ceil(len(group) / self._processes))
            del self._groups[key]
            if group[count:]:
                self._groups[key] = group[count:]
            self._free -= 1
            task = asyncio.create_task(self._run(group[:count]))
            self._running.add(task)
            task.add_done_callback(self._running.discard)

    async def _run(self, batch: list[Waiting]) -> None:
        try:
            await self._answer(batch)
        finally:
            self._free += 1
            self._start()

    async def _answer(self, batch: list[Waiting]) -> None:
        """Compute a batch, one by one if it killed its process, and tell each what became of it."""
        ask = self._compute.submit if len(batch) == 1 else self._compute.once
        try:
            outcomes = await ask(computed_predictions, [item for item, _ in batch])
        except BrokenProcessPool:
            for one in batch:
                await self._answer([one])
            return
        except Exception as error:  # noqa: BLE001 (raised again to whoever waits)
            outcomes = [error] * len(batch)
        for (_, answer), outcome in zip(batch, outcomes, strict=True):
            if answer.cancelled():
                continue
            if isinstance(outcome, Exception):
                answer.set_exception(outcome)
            else:
                answer.set_result(outcome)
