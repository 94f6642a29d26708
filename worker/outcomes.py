"""How jobs ended, counted in Redis for as long as it lives: what is shared by all workers and services."""

from dataclasses import dataclass
from typing import Literal, cast

from redis import Redis

from worker.connection import redis_failures

Ended = Literal["finished", "failed", "canceled"]

ENDED = "asperity:outcomes"
VERIFIED = "asperity:verified"
DICE_ERROR = "asperity:dice-error"


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

    def count(self, how: Ended) -> None:
        """Count a job that ended."""
        self.connection.hincrby(ENDED, how, 1)

    def count_verification(self, model: str, dice: float) -> None:
        """Count a finished verification of a model."""
        self.connection.hincrby(VERIFIED, model, 1)
        self.connection.hincrbyfloat(DICE_ERROR, model, 1 - dice)

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
