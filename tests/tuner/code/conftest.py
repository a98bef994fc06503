import pytest


@pytest.fixture(autouse=True)
def by_compiler(monkeypatch):
    """Steps are worked out by compiled C where there is a compiler, as by users."""
    monkeypatch.setenv("TUNER_NATIVE", "auto")
