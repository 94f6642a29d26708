"""The gate: who may do what, and how often; asked before anything of a body is read."""

import math
import time

from anyio import to_thread
from fastapi.security import HTTPBearer
from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage, RedisStorage
from limits.strategies import MovingWindowRateLimiter
from redis.exceptions import RedisError
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Send
from starlette.types import Scope as Connection

from app.api_key import Scope, digest
from app.errors import ForbiddenError, RateLimitedError, UnauthorizedError
from app.problems import problem_response
from app.settings import Settings
from solver.errors import AsperityError
from worker.connection import client

GUARDED = "/v1/"
BEARER = "bearer "

REDIS_TIMEOUT_S = 0.5
REDIS_PAUSE_S = 10.0
"""For which a Redis that did not answer is not asked again."""

bearer = HTTPBearer(auto_error=False, description="API key, where the service requires one")
"""For the documentation."""


class Gate:
    """ASGI middleware that lets requests in: GET reads, everything else writes.

    Requests are counted in the Redis that all service processes share; while it does not answer, each counts its own.

    Args:
        app: what is behind.
        settings: keys that are known; without any, everyone may do everything, so many times a minute.
    """

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self.app = app
        self.keys = {key.sha256: key for key in settings.api_keys}
        self.requests_per_minute = settings.requests_per_minute
        shared = RedisStorage("redis://", connection_pool=client(settings, timeout_s=REDIS_TIMEOUT_S).connection_pool)
        self._shared_again_at = 0.0
        self._limiters = [MovingWindowRateLimiter(storage) for storage in (shared, MemoryStorage())]

    async def __call__(self, scope: Connection, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer with the problem."""
        if scope["type"] == "http" and scope["path"].startswith(GUARDED):
            given = Headers(scope=scope).get("authorization", "")
            secret = given[len(BEARER) :].strip() if given.lower().startswith(BEARER) else None
            wanted: Scope = "read" if scope["method"] in ("GET", "HEAD") else "write"
            address = scope["client"][0] if scope["client"] else ""
            try:
                client_id, most = self.admit(secret, wanted, address)
                if most is not None:
                    await to_thread.run_sync(self.count, client_id, most)
            except AsperityError as error:
                await problem_response(error, scope["path"])(scope, receive, send)
                return
        await self.app(scope, receive, send)

    def admit(self, secret: str | None, scope: Scope, address: str) -> tuple[str, int | None]:
        """Who asks, and how many requests a minute they have.

        Raises:
            UnauthorizedError: no key, or an unknown one, where keys are required.
            ForbiddenError: a key without the scope.
        """
        if not self.keys:
            return address, self.requests_per_minute
        if secret is None:
            raise UnauthorizedError("This service requires an API key; send it as `Authorization: Bearer KEY`.")
        key = self.keys.get(digest(secret))
        if key is None:
            raise UnauthorizedError("This API key is not known; check it, or ask for a new one.")
        if scope not in key.scopes:
            raise ForbiddenError(f"The API key {key.name} lacks the scope {scope}; ask for a key that has it.")
        return key.sha256, key.requests_per_minute

    def count(self, client_id: str, most: int) -> None:
        """Count a request.

        Raises:
            RateLimitedError: more than so many within a minute.
        """
        shared, own = self._limiters
        if time.monotonic() >= self._shared_again_at:
            try:
                _hit(shared, most, client_id)
            except RedisError:
                self._shared_again_at = time.monotonic() + REDIS_PAUSE_S
            else:
                return
        _hit(own, most, client_id)


def _hit(limiter: MovingWindowRateLimiter, most: int, client_id: str) -> None:
    limit = RateLimitItemPerMinute(most)
    if not limiter.hit(limit, client_id):
        free_again_at = limiter.get_window_stats(limit, client_id).reset_time
        raise RateLimitedError(most, max(1, math.ceil(free_again_at - time.time())))
