"""API keys, of which the service knows only the hashes."""

from hashlib import sha256
from secrets import token_urlsafe
from typing import Literal

from pydantic import BaseModel, Field, PositiveInt, field_serializer

Scope = Literal["read", "write"]
"""``read`` is to look at what is there, ``write`` to have something computed, queued or canceled."""


class ApiKey(BaseModel):
    """A key as the settings hold it."""

    name: str
    sha256: str = Field(pattern="^[0-9a-f]{64}$")
    scopes: set[Scope] = {"read", "write"}
    requests_per_minute: PositiveInt | None = None

    @field_serializer("scopes")
    def _in_order(self, scopes: set[Scope]) -> list[Scope]:
        return sorted(scopes)


def new_key(name: str) -> tuple[str, ApiKey]:
    """A secret of 256 bits for a client, and what the settings must hold of it."""
    secret = token_urlsafe(32)
    return secret, ApiKey(name=name, sha256=digest(secret))


def digest(secret: str) -> str:
    """What a secret is known by."""
    return sha256(secret.encode()).hexdigest()
