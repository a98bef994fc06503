"""What a run does beside its searches and its comparisons."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from threading import Event, current_thread

import numpy as np
import pytest

from filters import AlphaBeta, AlphaBetaGains, LevelSample, LocalLevel
from objectives import Data, InnovationLikelihood
from tests.tuner.export_cases import tuned
from tuner import NelderMead, Positive, Problem, Space
from tuner.problem.exported import Trial
from tuner.problem.programs import run_filter, try_filter
from tuner.run import machine
from tuner.run.background_work import (
    begin_gradients,
    compile_checks,
    compile_gradients,
    compiled_ahead,
)

RECORD = Data(LevelSample(np.sin(0.3 * np.arange(73.0))), np.zeros(73))
LEVEL = Problem(
    name="level",
    space=Space.of(q=Positive(0.1, 1e-6, 1e3), R=Positive(0.2, 1e-6, 1e3)),
    filter=LocalLevel(dt=0.25),
    build=None,
    objective=InnovationLikelihood(),
    data=RECORD,
)


@pytest.fixture(autouse=True)
def all_done():
    """No thread is left to work in another test's folders."""
    before = {*threading.enumerate()}
    yield
    for thread in {*threading.enumerate()} - before:
        thread.join(60)


def test_checks_in_single_precision_are_compiled_ahead():
    def sizes():
        return [program._cache_size() for program in (run_filter, try_filter)]

    before = sizes()
    compile_checks(LEVEL)
    compiled = sizes()
    assert all(one > other for one, other in zip(compiled, before, strict=True))
    LEVEL.single_precision(NelderMead(seed=0, starts=1)(LEVEL))
    assert sizes() == compiled


def test_what_fails_ahead_is_left_for_its_end(monkeypatch):
    def fails(self, values):
        raise ValueError("not now")

    monkeypatch.setattr(Problem, "made", fails)
    compile_checks(LEVEL)


def test_c_is_compiled_beside_the_trial_of_its_filter(monkeypatch):
    measured = Event()
    tried = machine._tried

    def waits(*given):
        assert measured.wait(60), "the size was asked for after the trial"
        return tried(*given)

    monkeypatch.setattr(machine, "_tried", waits)
    monkeypatch.setattr(machine, "size", lambda *_: measured.set())
    trials = {"full": Trial(AlphaBeta(0.1), AlphaBetaGains(0.5, 0.1), np.arange(60.0))}
    found, records = machine.in_all_variants(tuned(name="track"), trials)
    assert [record.refused for record in records] == ["", ""]
    assert len(found) == 12
    assert b"track_selftest" in found["exports/float/track_selftest.c"]


def test_a_filter_that_cannot_be_tried_is_told_with_the_reason(monkeypatch):
    def fails(*_):
        raise ValueError("it has no samples")

    monkeypatch.setattr(machine, "_tried", fails)
    monkeypatch.setattr(machine, "size", lambda *_: None)
    trials = {"full": Trial(AlphaBeta(0.1), AlphaBetaGains(0.5, 0.1), np.arange(60.0))}
    found, records = machine.in_all_variants(tuned(name="track"), trials)
    assert found == {}
    assert [record.refused for record in records] == ["it has no samples"] * 2


def test_a_filter_that_cannot_be_tried_in_one_precision_is_tried_in_the_other(monkeypatch):
    tried = machine._tried

    def fails(found, before=None):
        if next(iter(found.values())).traced.precision == "double":
            raise ValueError("it has no samples")
        assert before is None
        return tried(found)

    monkeypatch.setattr(machine, "_tried", fails)
    monkeypatch.setattr(machine, "size", lambda *_: None)
    trials = {"full": Trial(AlphaBeta(0.1), AlphaBetaGains(0.5, 0.1), np.arange(60.0))}
    _, records = machine.in_all_variants(tuned(name="track"), trials)
    assert [record.refused for record in records] == ["it has no samples", ""]


@pytest.mark.usefixtures("stored")
def test_what_is_kept_is_compiled_ahead_and_waited_for_where_it_is_needed(monkeypatch):
    filter = LocalLevel(dt=float(np.random.default_rng().uniform(0.3, 0.4)))
    problem = replace(LEVEL, filter=filter)
    started, go_on = Event(), Event()
    differentiated = Problem.by_xla

    def waits(self, z):
        started.set()
        assert go_on.wait(60)
        return differentiated(self, z)

    monkeypatch.setattr(Problem, "by_xla", waits)
    with compiled_ahead(problem):
        assert started.wait(60)
    go_on.set()  # nobody has waited for it
    value, gradient = problem.by_xla(problem.space.start())
    assert np.isfinite([value, *gradient]).all()


def test_what_is_not_kept_is_waited_for(monkeypatch):
    done = []
    monkeypatch.setattr(Problem, "by_xla", lambda self, z: done.append(z))
    with compiled_ahead(LEVEL):
        pass
    assert len(done) == 1


@pytest.mark.parametrize("kept", [True, False])
def test_gradients_are_compiled_before_searches_begin_or_as_they_do(kept, monkeypatch, request):
    if kept:
        request.getfixturevalue("stored")
    threads = []
    monkeypatch.setattr(Problem, "by_xla", lambda self, z: threads.append(current_thread().name))
    twin = replace(LEVEL, name="twin")
    with ThreadPoolExecutor(1, "search") as pool:
        begin_gradients([LEVEL, twin])
        compile_gradients(pool, [LEVEL, twin])
    while not threads:
        time.sleep(0.01)
    assert [name.startswith("search") for name in threads] == [not kept]
