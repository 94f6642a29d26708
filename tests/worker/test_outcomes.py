"""How jobs ended, counted in a real Redis."""

import time

from redis import Redis
from rq.executions import Execution
from rq.job import JobStatus

from tests.worker.conftest import Wait, ended, rough, worker
from worker.job_queue import JobQueue
from worker.jobs import VerificationQueue
from worker.outcomes import Outcomes
from worker.parcel import JobKeys, Parcel
from worker.settings import Settings


def test_counts_add_up(connection: Redis) -> None:
    outcomes = Outcomes(connection)
    assert outcomes.read().ended == {}
    for _ in range(3):  # a job may end more than once
        outcomes.count("a", "finished", ("net-1", 0.75))
    outcomes.count("b", "finished", ("net-1", 1.0))
    outcomes.count("c", "finished")
    outcomes.count("d", "failed")
    found = outcomes.read()
    assert found.ended == {"finished": 3, "failed": 1}
    assert found.dice_errors == {"net-1": (2, 0.25)}


def test_a_job_canceled_just_before_it_starts_is_counted(
    queue: VerificationQueue, settings: Settings, connection: Redis, wait_for: Wait
) -> None:
    job_id = queue.enqueue(Parcel(rough(32)))
    JobKeys(connection, job_id).request_cancel(60)
    following = queue.enqueue(Parcel(rough(32)))
    with worker(settings):
        wait_for(following, ended)
    assert queue.state(job_id).status == "canceled"
    assert Outcomes(connection).read().ended == {"canceled": 1, "finished": 1}


def test_each_end_of_a_job_is_counted_once(
    queue: VerificationQueue, settings: Settings, connection: Redis, wait_for: Wait
) -> None:
    waiting = queue.enqueue(Parcel(rough(32)))
    queue.cancel(waiting)
    lost = queue.enqueue(Parcel(rough(32, seed=2)))
    connection.delete(f"asperity:parcel:{lost}")
    solve = queue.enqueue(Parcel(rough(32, seed=3)))
    predicted = rough(32).heights > 0
    verification = queue.enqueue(Parcel(rough(32, seed=4), predicted, model="net-1"))
    with worker(settings):
        states = [wait_for(job_id, ended) for job_id in (waiting, lost, solve, verification)]
        assert [state.status for state in states] == ["canceled", "failed", "finished", "finished"]
        assert queue.workers() == 1
    found = Outcomes(connection).read()
    assert found.ended == {"canceled": 1, "failed": 1, "finished": 2}
    assert found.dice_errors["net-1"][0] == 1
    assert queue.waiting() == 0


def test_a_job_that_is_lost_for_the_last_time_is_counted(queue: VerificationQueue, connection: Redis) -> None:
    job_id = queue.enqueue(Parcel(rough(32)))
    found = JobQueue.dequeue_any([queue.queue], 1, connection)
    assert found is not None
    job, _ = found
    job.retries_left = 0
    job.set_status(JobStatus.STARTED)
    job.save()
    with connection.pipeline() as pipeline:
        Execution.create(job, ttl=0, pipeline=pipeline)
        pipeline.execute()
    time.sleep(1.1)
    state = queue.state(job_id)
    assert (state.status, state.error) == ("failed", "Its worker was lost again and again.")
    assert Outcomes(connection).read().ended == {"failed": 1}
