"""The one place that says which Redis is meant, and what it means that it fails."""

from collections.abc import Iterator
from contextlib import contextmanager

from redis import Redis
from redis.exceptions import RedisError

from worker.embedded_redis import socket_path
from worker.errors import QueueUnavailableError
from worker.settings import Settings

CONNECT_TIMEOUT_S = 5


def connect(settings: Settings) -> Redis:
    """A connection that has answered a ping: to ``REDIS_URL``, else to the embedded server of the state directory.

    Raises:
        QueueUnavailableError: nothing answers there.
    """
    socket = socket_path(settings.state_path)
    try:
        if settings.redis_url:
            connection = Redis.from_url(settings.redis_url, socket_connect_timeout=CONNECT_TIMEOUT_S)
        else:
            connection = Redis(unix_socket_path=str(socket))
        connection.ping()
    except (RedisError, ValueError) as error:
        advice = (
            "check REDIS_URL"
            if settings.redis_url
            else f"start `asperity serve` with the state directory {settings.state_path}, or set REDIS_URL"
        )
        raise QueueUnavailableError(f"Redis does not answer ({error}); {advice}.") from error
    return connection


@contextmanager
def redis_failures() -> Iterator[None]:
    """Within it, as a block or as a decorator, what Redis refuses or loses is a QueueUnavailableError."""
    try:
        yield
    except RedisError as error:
        raise QueueUnavailableError(f"Redis failed ({error}); see its log, and try again.") from error
