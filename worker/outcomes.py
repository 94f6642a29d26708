"""How jobs ended, counted in Redis for as long as it lives: what is shared by all workers and services."""

from dataclasses import dataclass
from typing import Literal, cast

from redis import Redis

from worker.connection import redis_failures

Ended = Literal["finished", "failed", "canceled"]

ENDED = "asperity:outcomes"
VERIFIED = "asperity:verified"
DICE_ERROR = "asperity:dice-error"


COUNT_ONCE = """
if redis.call('SET', KEYS[1], ARGV[1], 'NX', 'EX', ARGV[2]) then
  redis.call('HINCRBY', KEYS[2], ARGV[1], 1)
  if ARGV[3] ~= '' then
    redis.call('HINCRBY', KEYS[3], ARGV[3], 1)
    redis.call('HINCRBYFLOAT', KEYS[4], ARGV[3], ARGV[4])
  end
end
"""
MARKED_S = 86400
"""For so long a job may come back from a worker that seemed lost."""


@dataclass(frozen=True)
class Counted:
    """Sums since the Redis was new.

    Attributes:
        ended: jobs by how they ended.
        dice_errors: by model, the number of finished verifications and the sum of their 1 - Dice.
    """

    ended: dict[str, int]
    dice_errors: dict[str, tuple[int, float]]


class Outcomes:
    """Counters in a Redis."""

    def __init__(self, connection: Redis) -> None:
        self.connection = connection

    def counted(self, job_id: str) -> bool:
        """Whether the end of a job was counted."""
        return bool(self.connection.exists(_mark(job_id)))

    def count(self, job_id: str, how: Ended, verified: tuple[str, float] | None = None) -> None:
        """Count the end of a job, once, however often it is called.

        Args:
            job_id: of the job.
            how: it ended.
            verified: model and Dice, of a verification that proves something.
        """
        model, dice = verified or ("", 1.0)
        keys = [_mark(job_id), ENDED, VERIFIED, DICE_ERROR]
        self.connection.eval(COUNT_ONCE, len(keys), *keys, how, MARKED_S, model, repr(1 - dice))

    @redis_failures()
    def read(self) -> Counted:
        """All that was counted.

        Raises:
            QueueUnavailableError: Redis fails.
        """
        ended, verified, errors = (self._hash(key) for key in (ENDED, VERIFIED, DICE_ERROR))
        return Counted(
            {how: int(count) for how, count in ended.items()},
            {model: (int(count), float(errors.get(model, 0))) for model, count in verified.items()},
        )

    def _hash(self, key: str) -> dict[str, str]:
        found = cast(dict[bytes, bytes], self.connection.hgetall(key))
        return {name.decode(): value.decode() for name, value in found.items()}


def _mark(job_id: str) -> str:
    return f"asperity:ended:{job_id}"
