"""The one place that says which Redis is meant."""

from redis import Redis
from redis.exceptions import RedisError

from worker.embedded_redis import socket_path
from worker.errors import QueueUnavailableError
from worker.settings import Settings


def connect(settings: Settings) -> Redis:
    """A connection that has answered a ping: to ``REDIS_URL``, else to the embedded server of the state directory.

    Raises:
        QueueUnavailableError: nothing answers there.
    """
    socket = socket_path(settings.state_path)
    connection = Redis.from_url(settings.redis_url) if settings.redis_url else Redis(unix_socket_path=str(socket))
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
