"""API keys: who may do what, and how often. Only their hashes are known to the service."""

from hashlib import sha256
from secrets import token_urlsafe
from typing import Annotated, Literal

from fastapi import Depends, Request
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer
from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter
from pydantic import BaseModel, Field, PositiveInt

from app.errors import ForbiddenError, RateLimitedError, UnauthorizedError

Scope = Literal["read", "write"]
"""``read`` is to look at what is there, ``write`` to have something computed, queued or canceled."""


class ApiKey(BaseModel):
    """A key as the settings hold it."""

    name: str
    sha256: str = Field(pattern="^[0-9a-f]{64}$")
    scopes: set[Scope] = {"read", "write"}
    requests_per_minute: PositiveInt | None = None


def new_key(name: str) -> tuple[str, ApiKey]:
    """A secret of 256 bits for a client, and what the settings must hold of it."""
    secret = token_urlsafe(32)
    return secret, ApiKey(name=name, sha256=_hash(secret))


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
        key = self.keys.get(_hash(secret))
        if key is None:
            raise UnauthorizedError("This API key is not known; check it, or ask for a new one.")
        if scope not in key.scopes:
            raise ForbiddenError(f"The API key {key.name} lacks the scope {scope}; ask for a key that has it.")
        self._count(key.sha256, key.requests_per_minute)

    def _count(self, client: str, most: int | None) -> None:
        if most is not None and not self._limiter.hit(RateLimitItemPerMinute(most), client):
            raise RateLimitedError(f"More than {most} requests within a minute; wait, and try again.")


def _hash(secret: str) -> str:
    return sha256(secret.encode()).hexdigest()


bearer = HTTPBearer(auto_error=False, description="API key, where the service requires one")


def authorize(request: Request, given: Annotated[HTTPAuthorizationCredentials | None, Depends(bearer)]) -> None:
    """Dependency of all routes that need a key: GET reads, everything else writes."""
    gate: Gate = request.app.state.gate
    scope: Scope = "read" if request.method in ("GET", "HEAD") else "write"
    gate.admit(None if given is None else given.credentials, scope, request.client.host if request.client else "")
