"""Settings of queue, workers and stored results, read from the environment."""

import os
from pathlib import Path

from pydantic import Field, PositiveFloat, PositiveInt, SecretStr
from pydantic_settings import BaseSettings, SettingsConfigDict


def _user_state_dir() -> Path:
    """Where the XDG base directory specification puts the state of a program."""
    return Path(os.environ.get("XDG_STATE_HOME") or "~/.local/state") / "asperity"


class Settings(BaseSettings):
    """What a worker needs to know; the prefix of the variables is ``ASPERITY_``."""

    model_config = SettingsConfigDict(env_prefix="ASPERITY_", env_ignore_empty=True, populate_by_name=True)

    state_dir: Path = Field(
        default_factory=_user_state_dir, description="directory of the embedded Redis and of stored results"
    )
    results: str | None = Field(
        default=None, description="where results are stored, a directory or URL for fsspec; in state_dir if left out"
    )
    redis_url: str | None = Field(
        default=None, validation_alias="REDIS_URL", description="Redis to use; the embedded one if left out"
    )
    redis_memory_mib: PositiveInt = Field(
        default=2048, description="memory of the Redis, in MiB, beyond which new jobs are refused"
    )
    worker_memory_mib: PositiveInt = Field(
        default=8192, description="memory of a worker, in MiB; jobs that would take more are refused"
    )
    queue_length: PositiveInt = Field(default=100, description="jobs that may wait before new ones are refused")
    job_timeout_s: PositiveInt = Field(default=3600, description="seconds after which a job is ended as failed")
    webhook_secret: SecretStr | None = Field(
        default=None, description="signs webhooks, HMAC-SHA256; without it none are sent"
    )
    webhook_private: bool = Field(default=False, description="whether webhooks may go to addresses that are not public")
    retention_days: PositiveFloat = Field(default=7.0, description="days for which jobs and predictions are kept")

    @property
    def state_path(self) -> Path:
        """``state_dir`` with the home directory filled in."""
        return self.state_dir.expanduser().resolve()

    @property
    def results_place(self) -> str:
        """``results``, or the directory that takes its place."""
        return self.results or str(self.state_path / "results")

    @property
    def retention_s(self) -> int:
        """``retention_days`` in seconds."""
        return int(self.retention_days * 86400)
