"""Settings of the service, read from the environment."""

import os
from pathlib import Path

from pydantic import Field, NonNegativeInt, PositiveInt, ValidationError
from pydantic_settings import SettingsError

from app.api_key import ApiKey
from app.errors import InvalidSettingsError
from worker.settings import Settings as WorkerSettings


class Settings(WorkerSettings):
    """What the service needs to know besides queue and results; the prefix of the variables is ``ASPERITY_``."""

    host: str = Field(default="127.0.0.1", description="address to listen on")
    port: PositiveInt = Field(default=8000, le=65535, description="port to listen on")
    workers: NonNegativeInt = Field(default=1, description="worker processes that `asperity serve` keeps running")
    upload_limit_mib: PositiveInt = Field(default=64, description="largest upload, in MiB")
    weights: Path | None = Field(
        default=None, description="directory of the weights that predict; the shipped ones if left out"
    )
    compute_processes: PositiveInt = Field(
        default_factory=lambda: min(4, os.cpu_count() or 1),
        description="processes that compute predictions; each takes about half a GiB",
    )
    requests_waiting: PositiveInt = Field(
        default=1000, description="requests that may wait to be computed before new ones are refused"
    )
    requests_per_minute: PositiveInt | None = Field(
        default=None, description="requests a minute and address, where no API keys are required; any number if left out"
    )
    api_keys: list[ApiKey] = Field(
        default=[], description="keys that are required, as JSON; see `asperity key`; none are if left out"
    )


def read_settings() -> Settings:
    """The settings of the environment.

    Raises:
        InvalidSettingsError: a variable that cannot be used; the message names it.
    """
    try:
        return Settings()
    except SettingsError as error:
        raise InvalidSettingsError(f"{error}: it must be JSON; see docs/operations.md.") from error
    except ValidationError as error:
        faults = [f"{_variable(str(fault['loc'][0]))} is {fault['input']!r}: {fault['msg']}." for fault in error.errors()]
        raise InvalidSettingsError(" ".join(faults)) from error


def _variable(name: str) -> str:
    return name if name.isupper() else f"ASPERITY_{name.upper()}"
