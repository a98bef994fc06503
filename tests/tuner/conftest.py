import os
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

import tuner.catalogue
from tests.tuner.helpers import toy_study
from tests.tuner.stored import forget
from tuner import code_version
from tuner.cli import invoke


@pytest.fixture(scope="session")
def cache():
    """The folder of compiled code, for this process and those it starts."""
    return Path(os.environ["TUNER_CACHE"])


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def stored(tmp_path, monkeypatch):
    """Programs are stored in a folder of the test's own; the source may have been edited now."""
    monkeypatch.setenv("TUNER_PROGRAMS", "stored")
    monkeypatch.setenv("TUNER_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(code_version, "changed_since", lambda _: False)
    forget()
    yield
    forget()


@pytest.fixture
def cli(cache, here, capfdbinary):
    """Run the command line in an empty folder: exit code, stdout and stderr."""

    def run(*arguments):
        capfdbinary.readouterr()
        code = invoke([str(argument) for argument in arguments])
        out, err = capfdbinary.readouterr()
        return code, out.decode(), err.decode()

    return run


@pytest.fixture
def offer(monkeypatch):
    """Make a study known under the name toy, beside the installed ones."""

    class Offered(EntryPoint):
        def load(self):
            return self.value

    def offered(study):
        new, installed = Offered(study.name, study, "tuner.studies"), tuner.catalogue.entry_points

        def points(group):
            kept = [point for point in installed(group=group) if point.name != study.name]
            return [*kept, new] if group == "tuner.studies" else kept

        monkeypatch.setattr(tuner.catalogue, "entry_points", points)
        return study

    return offered


@pytest.fixture
def toy(offer):
    """The study of :mod:`tests.tuner.helpers`."""
    return offer(toy_study())
