import pytest

from worker.connection import connect
from worker.errors import QueueUnavailableError
from worker.settings import Settings


def test_a_redis_that_does_not_answer_is_said_so(settings: Settings) -> None:
    with pytest.raises(QueueUnavailableError, match="asperity serve"):
        connect(settings)
    with pytest.raises(QueueUnavailableError, match="REDIS_URL"):
        connect(settings.model_copy(update={"redis_url": "redis://127.0.0.1:1/0"}))
    with pytest.raises(QueueUnavailableError, match="REDIS_URL"):
        connect(settings.model_copy(update={"redis_url": "localhost"}))
