"""The gate: who may do what, and how often."""

from typing import Annotated

from fastapi import Depends, Request
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer
from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from app.api_key import ApiKey, Scope, digest
from app.errors import ForbiddenError, RateLimitedError, UnauthorizedError


class Gate:
    """Lets requests in.

    Args:
        keys: that are known; without any, everyone may do everything.
        requests_per_minute: of each client that needs no key; None for any number.
    """

    def __init__(self, keys: list[ApiKey], requests_per_minute: int | None) -> None:
        self.keys = {key.sha256: key for key in keys}
        self.requests_per_minute = requests_per_minute
        self._limiter = MovingWindowRateLimiter(MemoryStorage())

    def admit(self, secret: str | None, scope: Scope, address: str) -> None:
        """Let a request in.

        Raises:
            UnauthorizedError: no key, or an unknown one, where keys are required.
            ForbiddenError: a key without the scope.
            RateLimitedError: too many requests within a minute.
        """
        if not self.keys:
            self._count(address, self.requests_per_minute)
            return
        if secret is None:
            raise UnauthorizedError("This service requires an API key; send it as `Authorization: Bearer KEY`.")
        key = self.keys.get(digest(secret))
        if key is None:
            raise UnauthorizedError("This API key is not known; check it, or ask for a new one.")
        if scope not in key.scopes:
            raise ForbiddenError(f"The API key {key.name} lacks the scope {scope}; ask for a key that has it.")
        self._count(key.sha256, key.requests_per_minute)

    def _count(self, client: str, most: int | None) -> None:
        if most is not None and not self._limiter.hit(RateLimitItemPerMinute(most), client):
            raise RateLimitedError(f"More than {most} requests within a minute; wait, and try again.")


bearer = HTTPBearer(auto_error=False, description="API key, where the service requires one")


def authorize(request: Request, given: Annotated[HTTPAuthorizationCredentials | None, Depends(bearer)]) -> None:
    """Dependency of all routes that need a key: GET reads, everything else writes."""
    gate: Gate = request.app.state.gate
    scope: Scope = "read" if request.method in ("GET", "HEAD") else "write"
    gate.admit(None if given is None else given.credentials, scope, request.client.host if request.client else "")
