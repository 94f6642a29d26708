"""The end of a job: announced and counted, once, though a job may end twice because its worker seemed lost."""

from rq.job import Job

from worker.outcomes import Ended, Outcomes
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
