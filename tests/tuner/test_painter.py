"""Pictures of another process are those of this one, and none is lost where it fails."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from io import BytesIO
from threading import Barrier

import numpy as np
import pytest
from matplotlib.layout_engine import ConstrainedLayoutEngine

from tuner.run import painter
from tuner.run.drawing import picture
from tuner.run.figure import Chart, Line
from tuner.run.painter import Painter
from tuner.run.painter_worker import read, serve, write

CHART = Chart("chart", "A title", "time, s", "m", (Line("one", np.arange(3.0), np.arange(3.0)),))


@dataclass(frozen=True)
class Strange:
    """Something that is no figure."""

    log: str = ""


@pytest.fixture(autouse=True)
def laid_out(rough, monkeypatch):
    """Pictures as users see them, here as there."""
    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", rough)


@pytest.fixture
def begun(stored, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    found = Painter()
    found.begin(1)
    assert found.processes == 1
    yield found
    found.end()


@pytest.fixture
def not_here(monkeypatch):
    def refused(_):
        raise AssertionError("drawn here")

    monkeypatch.setattr(painter, "picture", refused)


def test_a_picture_of_another_process_is_the_same(begun, not_here):
    assert begun.picture(CHART) == begun.picture(CHART) == picture(CHART)
    (process,) = begun._begun
    begun.end()
    assert process.returncode == 0


def test_what_fails_there_fails_here_with_its_reason(begun):
    with pytest.raises(AttributeError, match="'Strange' object has no attribute 'x_label'"):
        begun.picture(Strange())
    assert begun.picture(CHART) == picture(CHART)


def test_a_process_that_has_died_is_done_without(begun):
    (process,) = begun._begun
    process.kill()
    process.wait()
    assert begun.picture(CHART) == begun.picture(CHART) == picture(CHART)


@pytest.mark.usefixtures("stored")
def test_without_another_processor_it_is_drawn_here(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    alone = Painter()
    alone.begin(2)
    assert not alone.processes
    assert alone.picture(CHART) == picture(CHART)


@pytest.mark.usefixtures("stored")
def test_several_processes_draw_side_by_side(monkeypatch, not_here):
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    found, together = Painter(), Barrier(2, timeout=60)
    found.begin(3)
    assert found.processes == 2
    asked = []

    def reading(stream):
        asked.append(stream)
        together.wait()  # both were asked before one has answered
        return read(stream)

    monkeypatch.setattr(painter, "read", reading)
    with ThreadPoolExecutor(2) as pool:
        one, other = pool.map(found.picture, [CHART, CHART])
    found.end()
    assert one == other == picture(CHART)
    assert len(set(map(id, asked))) == 2


def test_the_other_end_answers_each_figure_in_its_turn():
    def draw(name):
        if name == "wrong":
            raise ValueError(name)
        return name.encode()

    asked, answers = BytesIO(), BytesIO()
    for name in ("one", "wrong", "two"):
        write(asked, pickle.dumps(name))
    serve(BytesIO(asked.getvalue() + b"cut short"), answers, draw)
    found = BytesIO(answers.getvalue())
    assert [read(found) for _ in range(3)] == [b"one", b"", b"two"]
