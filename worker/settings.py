"""Settings of queue, workers and stored results, read from the environment."""

from pathlib import Path

from pydantic import Field, PositiveFloat, PositiveInt
from pydantic_settings import BaseSettings, SettingsConfigDict


class Settings(BaseSettings):
    """What a worker needs to know; the prefix of the variables is ``ASPERITY_``."""

    model_config = SettingsConfigDict(env_prefix="ASPERITY_", env_ignore_empty=True)

    state_dir: Path = Field(
        default=Path("~/.local/state/asperity"), description="directory of the embedded Redis and of stored results"
    )
    redis_url: str | None = Field(
        default=None, validation_alias="REDIS_URL", description="Redis to use; the embedded one if left out"
    )
    queue_length: PositiveInt = Field(default=100, description="jobs that may wait before new ones are refused")
    job_timeout_s: PositiveInt = Field(default=3600, description="seconds after which a job is ended as failed")
    retention_days: PositiveFloat = Field(default=7.0, description="days for which jobs and predictions are kept")

    @property
    def state_path(self) -> Path:
        """``state_dir`` with the home directory filled in."""
        return self.state_dir.expanduser().resolve()

    @property
    def retention_s(self) -> int:
        """``retention_days`` in seconds."""
        return int(self.retention_days * 86400)
