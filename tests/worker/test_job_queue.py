import pytest
from redis import Redis
from rq.exceptions import DequeueTimeout

from tests.worker.conftest import Wait, ended, rough, worker
from worker import job_queue
from worker.job_queue import MAINTENANCE_LOCK_S, SHARDS, VERIFICATIONS, JobQueue
from worker.jobs import VerificationQueue
from worker.parcel import Parcel
from worker.settings import Settings


def test_a_killed_holder_of_the_maintenance_lock_holds_up_nobody_for_long(connection: Redis) -> None:
    queue = JobQueue(connection)
    assert queue.acquire_maintenance_lock()
    assert not queue.acquire_maintenance_lock()
    assert 0 < connection.ttl(queue.registry_cleaning_key) <= MAINTENANCE_LOCK_S
    queue.release_maintenance_lock()
    assert queue.acquire_maintenance_lock()


def test_jobs_are_taken_in_the_order_of_queues_and_arrival(connection: Redis) -> None:
    first, second = (JobQueue(connection, name=name) for name in (VERIFICATIONS, SHARDS))
    for queue, name in ((second, "c"), (first, "a"), (first, "b")):
        queue.submit("worker.shards.make_shard", name, "", 60)
    taken = [JobQueue.dequeue_any([first, second], 1, connection) for _ in range(3)]
    assert [(found[0].id, found[1].name) for found in taken if found] == [
        ("a", VERIFICATIONS),
        ("b", VERIFICATIONS),
        ("c", SHARDS),
    ]
    assert JobQueue.dequeue_any([first, second], None, connection) is None
    with pytest.raises(DequeueTimeout):
        JobQueue.dequeue_any([first, second], 1, connection)


def test_a_job_that_was_taken_and_not_started_is_put_back(
    queue: VerificationQueue, connection: Redis, settings: Settings, wait_for: Wait, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(job_queue, "UNSTARTED_S", 0.0)
    job_id = queue.enqueue(Parcel(rough(32)))
    jobs = queue.queue
    assert JobQueue.dequeue_any([jobs], 1, connection)  # by a worker that is lost at once
    assert queue.waiting() == 0
    jobs.taken.cleanup(None, jobs)  # type: ignore[arg-type]
    assert queue.waiting() == 0  # it may yet be started
    jobs.taken.cleanup(None, jobs)  # type: ignore[arg-type]
    assert queue.waiting() == 1
    with worker(settings):
        assert wait_for(job_id, ended).status == "finished"
    assert jobs.taken.get_job_ids() == []
