"""The one place that says which Redis is meant, and what it means that it fails."""

from collections.abc import Iterator
from contextlib import contextmanager

from redis import Redis
from redis.backoff import ExponentialBackoff, NoBackoff
from redis.exceptions import RedisError
from redis.retry import Retry

from worker.embedded_redis import socket_path
from worker.errors import QueueUnavailableError
from worker.settings import Settings

TIMEOUT_S = 10.0
"""After which a Redis that says nothing counts as lost."""


ONCE_MORE = Retry(NoBackoff(), 1)
"""A connection that has been lost since it was last used is made anew."""

PATIENTLY = Retry(ExponentialBackoff(cap=1.0, base=0.02), 60)
"""For about a minute: a Redis that restarts costs a worker nothing but time."""


def client(settings: Settings, retry: Retry = ONCE_MORE, timeout_s: float = TIMEOUT_S) -> Redis:
    """A client of ``REDIS_URL``, else of the embedded server of the state directory; it connects when it is first used.

    Raises:
        QueueUnavailableError: a REDIS_URL that is none.
    """
    if settings.redis_url:
        try:
            return Redis.from_url(
                settings.redis_url, socket_connect_timeout=timeout_s, socket_timeout=timeout_s, retry=retry
            )
        except ValueError as error:
            raise QueueUnavailableError(f"REDIS_URL cannot be used: {error}") from error
    return Redis(unix_socket_path=str(socket_path(settings.state_path)), socket_timeout=timeout_s, retry=retry)


def connect(settings: Settings) -> Redis:
    """A client that has got an answer to a ping.

    Raises:
        QueueUnavailableError: nothing answers there.
    """
    connection = client(settings)
    try:
        connection.ping()
    except RedisError as error:
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
