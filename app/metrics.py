"""What Prometheus reads at /metrics: of this process, and of the queue that all processes share."""

import asyncio
from collections.abc import Callable, Iterator
from time import perf_counter

from prometheus_client import CollectorRegistry, Counter, Histogram, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from app.schemas import Numbers
from worker.errors import QueueUnavailableError
from worker.jobs import VerificationQueue
from worker.outcomes import Outcomes

WATCH_EVERY_S = 0.05
SECONDS = (0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0)


class Metrics:
    """Counters and histograms of one process.

    Args:
        queue: gives the queue, for what is shared; asked at every reading.
    """

    def __init__(self, queue: Callable[[], VerificationQueue]) -> None:
        self.registry = CollectorRegistry()
        self.requests = Histogram(
            "asperity_request_seconds",
            "Time to answer requests",
            ["method", "route", "status"],
            buckets=SECONDS,
            registry=self.registry,
        )
        self.stages = Histogram(
            "asperity_prediction_stage_seconds",
            "Time of predictions by stage",
            ["stage"],
            buckets=SECONDS,
            registry=self.registry,
        )
        self.predictions = Counter(
            "asperity_predictions", "Predictions by what answered them", ["method"], registry=self.registry
        )
        self.lag = Histogram(
            "asperity_event_loop_lag_seconds",
            "How much later than asked for the event loop goes on",
            buckets=SECONDS,
            registry=self.registry,
        )
        self.registry.register(_Shared(queue))

    def predicted(self, numbers: Numbers) -> None:
        """Count a prediction that was computed."""
        self.predictions.labels(numbers.method).inc()
        for stage, milliseconds in numbers.timings_ms.items():
            self.stages.labels(stage).observe(milliseconds / 1e3)

    async def watch_loop(self) -> None:
        """Measure the lag of the event loop, for ever."""
        while True:
            started = perf_counter()
            await asyncio.sleep(WATCH_EVERY_S)
            self.lag.observe(max(0.0, perf_counter() - started - WATCH_EVERY_S))

    def text(self) -> bytes:
        """In the text format of Prometheus."""
        return generate_latest(self.registry)


class _Shared(Collector):
    """Queue depth, outcomes of jobs, and the live accuracy of every model: Dice of finished verifications."""

    def __init__(self, queue: Callable[[], VerificationQueue]) -> None:
        self.queue = queue

    def collect(self) -> Iterator[Metric]:
        try:
            queue = self.queue()
            waiting, workers, outcomes = queue.waiting(), queue.workers(), Outcomes(queue.connection).read()
        except QueueUnavailableError:
            yield GaugeMetricFamily("asperity_queue_up", "Whether the queue answers", value=0)
            return
        yield GaugeMetricFamily("asperity_queue_up", "Whether the queue answers", value=1)
        yield GaugeMetricFamily("asperity_jobs_waiting", "Jobs that wait for a worker", value=waiting)
        yield GaugeMetricFamily("asperity_workers", "Workers that take jobs", value=workers)
        ended = CounterMetricFamily("asperity_jobs_ended", "Jobs by how they ended", labels=["status"])
        for status, count in outcomes.ended.items():
            ended.add_metric([status], count)
        yield ended
        verified = CounterMetricFamily("asperity_verifications", "Finished verifications by model", labels=["model"])
        error = CounterMetricFamily("asperity_dice_error", "Sum of 1 - Dice of finished verifications", labels=["model"])
        for model, (count, total) in outcomes.dice_errors.items():
            verified.add_metric([model], count)
            error.add_metric([model], total)
        yield verified
        yield error
