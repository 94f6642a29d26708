"""Verifications by a real worker."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from redis import Redis
from rq.job import Job
from rq.serializers import JSONSerializer

from model import compare
from solver import boyer_resistance, solve
from tests.worker.conftest import Wait, ended, rough, worker
from worker.jobs import VerificationQueue
from worker.parcel import JobKeys, Parcel
from worker.settings import Settings

COPPER = 1.7e-8


def test_a_verification_compares_the_prediction_with_a_reference_solve(
    queue: VerificationQueue, settings: Settings, wait_for: Wait
) -> None:
    problem = rough(64)
    truth = solve(problem).contact_mask
    predicted = np.roll(truth, 1, axis=0)
    with worker(settings):
        state = wait_for(queue.enqueue(Parcel(problem, predicted, COPPER)), ended)
        bare = wait_for(queue.enqueue(Parcel(problem, truth, None)), ended)
    assert state.status == "finished"
    assert state.comparison is not None
    assert state.reference is not None
    expected = compare(truth, predicted)
    for name in ("dice", "jaccard", "bf_score", "pixel_accuracy", "area_error"):
        assert state.comparison[name] == pytest.approx(getattr(expected, name))
    resistances = [boyer_resistance(mask, problem.pixel_size, COPPER) for mask in (predicted, truth)]
    assert state.comparison["resistance_error"] == pytest.approx(resistances[0] / resistances[1] - 1)
    assert state.reference["contact_resistance_ohm"] == pytest.approx(resistances[1])
    assert state.reference["contact_area_mm2"] == pytest.approx(truth.mean())
    assert state.reference["converged"]
    assert state.reference["residual"] <= 1e-6
    mask = np.asarray(Image.open(BytesIO(queue.reference_mask(state.id))))
    np.testing.assert_array_equal(mask, truth)
    assert bare.comparison is not None
    assert (bare.comparison["dice"], bare.comparison["resistance_error"]) == (1, None)


def test_a_job_that_has_finished_and_is_run_again_keeps_its_result(
    queue: VerificationQueue, settings: Settings, connection: Redis, wait_for: Wait
) -> None:
    with worker(settings):
        first = wait_for(queue.enqueue(Parcel(rough(32), np.ones((32, 32), dtype=bool), None)), ended)
        JobKeys(connection, first.id).drop_parcel()
        queue.queue.enqueue_job(Job.fetch(first.id, connection, JSONSerializer))
        second = wait_for(queue.enqueue(Parcel(rough(32), np.ones((32, 32), dtype=bool), None)), ended)
        assert second.status == "finished"
    assert queue.state(first.id).status == "finished"
    assert queue.state(first.id).reference == first.reference


def test_a_problem_is_not_kept_for_long_after_its_verification(
    queue: VerificationQueue, settings: Settings, connection: Redis, wait_for: Wait
) -> None:
    job_id = queue.enqueue(Parcel(rough(32), np.ones((32, 32), dtype=bool), None))
    parcel = JobKeys(connection, job_id).parcel
    assert connection.ttl(parcel) > settings.retention_s / 2
    with worker(settings):
        wait_for(job_id, ended)
    assert connection.ttl(parcel) <= 600
