"""Fixtures of the tests of closures."""

import pytest

from contbed.closures import registry


@pytest.fixture
def scratch_register(monkeypatch):
    """Closures that a test registers are gone after it."""
    monkeypatch.setattr(registry, "_register", dict(registry._register))
