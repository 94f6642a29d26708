from pathlib import Path

import pytest
from pydantic import ValidationError

from worker.settings import Settings


@pytest.fixture(autouse=True)
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ASPERITY_STATE_DIR", "REDIS_URL", "XDG_STATE_HOME"):
        monkeypatch.delenv(name, raising=False)


def test_the_state_directory_follows_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Settings().state_path == Path.home().resolve() / ".local/state/asperity"
    monkeypatch.setenv("XDG_STATE_HOME", "/var/states")
    assert Settings().state_path == Path("/var/states/asperity")
    monkeypatch.setenv("ASPERITY_STATE_DIR", "/srv/asperity")
    assert Settings().state_path == Path("/srv/asperity")


def test_a_redis_is_named_by_its_usual_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Settings().redis_url is None
    monkeypatch.setenv("REDIS_URL", "redis://queue:6379/0")
    assert Settings().redis_url == "redis://queue:6379/0"


def test_a_number_out_of_range_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ASPERITY_RETENTION_DAYS", "-1")
    with pytest.raises(ValidationError, match="retention_days"):
        Settings()
