from redis import Redis

from worker.job_queue import MAINTENANCE_LOCK_S, JobQueue


def test_a_killed_holder_of_the_maintenance_lock_holds_up_nobody_for_long(connection: Redis) -> None:
    queue = JobQueue(connection)
    assert queue.acquire_maintenance_lock()
    assert not queue.acquire_maintenance_lock()
    assert 0 < connection.ttl(queue.registry_cleaning_key) <= MAINTENANCE_LOCK_S
    queue.release_maintenance_lock()
    assert queue.acquire_maintenance_lock()
