"""The end of a job: announced and counted, once, though a job may end twice because its worker seemed lost."""

from redis.exceptions import RedisError
from rq.exceptions import AbandonedJobError
from rq.job import Job

from worker.job_queue import VERIFICATIONS, WEBHOOKS
from worker.outcomes import Ended, Outcomes
from worker.parcel import JobKeys
from worker.webhooks import announce


def end(job: Job, how: Ended, verified: tuple[str, float] | None = None) -> None:
    """Announce and count; killed in between it announces again, which receivers know by the id of the message.

    Args:
        job: that ended.
        how: it did.
        verified: model and Dice, of a verification that proves something.
    """
    outcomes = Outcomes(job.connection)
    if not outcomes.counted(job.id):
        announce(job, how)
        outcomes.count(job.id, how, verified)


def fail_for_good(job: Job, kind: type[BaseException], error: BaseException, traceback: object) -> None:
    """A solve that raised would raise again: only the loss of its process or its Redis is a reason to try it again."""
    if job.origin != WEBHOOKS and not issubclass(kind, (AbandonedJobError, RedisError)):
        job.retries_left = 0
        JobKeys(job.connection, job.id).drop_parcel()
    if job.origin == VERIFICATIONS and kind is AbandonedJobError and not job.retries_left:  # RQ tells nobody else
        end(job, "failed")
