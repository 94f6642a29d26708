"""Settings of the environment."""

from pathlib import Path

import pytest

from app.errors import InvalidSettingsError
from app.settings import Settings, read_settings


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ASPERITY_PORT", "1234")
    monkeypatch.setenv("REDIS_URL", "redis://elsewhere")
    settings = read_settings()
    assert settings.port == 1234
    assert settings.redis_url == "redis://elsewhere"


@pytest.mark.parametrize(("name", "value"), [("ASPERITY_PORT", "high"), ("ASPERITY_WORKERS", "-1")])
def test_a_variable_that_cannot_be_used_is_named(monkeypatch: pytest.MonkeyPatch, name: str, value: str) -> None:
    monkeypatch.setenv(name, value)
    with pytest.raises(InvalidSettingsError, match=f"{name} is '{value}'"):
        read_settings()


def test_every_setting_is_documented() -> None:
    document = (Path(__file__).parents[2] / "docs/operations.md").read_text()
    for name, field in Settings.model_fields.items():
        variable = str(field.validation_alias or f"ASPERITY_{name.upper()}")
        assert f"`{variable}`" in document, variable
        assert field.description


def test_keys_that_are_no_json_are_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ASPERITY_API_KEYS", "alice")
    with pytest.raises(InvalidSettingsError, match=r"api_keys.*must be JSON"):
        read_settings()
