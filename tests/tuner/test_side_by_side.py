"""Descents from several starts at the same time: the same ends, and none that goes on alone."""

import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

from objectives import Data
from tests.tuner.helpers import bowl, crater, problem
from tuner.problem.problem import NO_DATA
from tuner.solvers import multistart, side_by_side
from tuner.solvers.blas import blas_on_one_thread
from tuner.solvers.gradient import Gradient
from tuner.solvers.minimum import Minimum
from tuner.solvers.nelder_mead import NelderMead
from tuner.solvers.side_by_side import descents

PATIENCE = 30  # s


def end(z, value=1.0):
    return Minimum(np.atleast_1d(z), float(value), 1, True, "")


@pytest.fixture
def processors(monkeypatch):
    """So many processors, of whatever machine."""
    return lambda count: monkeypatch.setattr("os.cpu_count", lambda: count)


def stub(value=lambda z: 0.0, data=NO_DATA):
    """A problem that has nothing but values."""
    return SimpleNamespace(known_starts=(), data=data, value=value, seconds=[])


@pytest.fixture
def at_once(monkeypatch):
    """Evaluations are taken for long ones from the beginning."""
    monkeypatch.setattr(side_by_side, "MANY", 0)


@pytest.mark.parametrize("many", [0, 10**9], ids=["at once", "as they are short"])
@pytest.mark.parametrize("solver", [Gradient("l-bfgs-b", seed=1, starts=4), NelderMead(1, 4)])
@pytest.mark.parametrize("objective", [bowl, crater], ids=["bowl", "first start is lost"])
def test_ends_are_those_of_one_thread(solver, objective, many, processors, monkeypatch):
    monkeypatch.setattr(side_by_side, "MANY", many)
    processors(3)
    found = []
    for threads in (1, 3):
        monkeypatch.setattr(multistart, "_threads", lambda problem, threads=threads: threads)
        found.append(solver(problem(objective)))
    one, other = (replace(solution, seconds=0.0) for solution in found)
    assert one.z.tobytes() == other.z.tobytes()
    assert (one.value, one.evaluations, one.message) == (
        other.value,
        other.evaluations,
        other.message,
    )
    assert one.certificate.starts == other.certificate.starts


@pytest.mark.usefixtures("at_once")
def test_long_descents_run_at_the_same_time(processors):
    processors(2)
    together = threading.Barrier(2)

    def descend(problem, z):
        together.wait(PATIENCE)
        return end(z)

    ends = descents(problem(bowl), descend, np.arange(8.0), 4, threads=2)
    assert [found.z.item() for found in ends] == [0, 1, 2, 3]


SHORT, LONG = 1e-5, 1e-3


@pytest.fixture
def clock(monkeypatch):
    """A clock that only evaluations move, which take so long one after another."""
    time = [0.0]
    monkeypatch.setattr(side_by_side, "time", SimpleNamespace(perf_counter=lambda: time[0]))

    def posed(seconds):
        each = iter(seconds)

        def value(z):
            time[0] += next(each)

        return stub(value)

    return posed


@pytest.mark.parametrize(
    ("seconds", "threads"),
    [
        ([0.2, 0.9, LONG, LONG, LONG], 2),
        ([0.2, 0.9, LONG, LONG], 1),
        ([0.2, 0.9, LONG, SHORT, LONG, LONG, LONG], 1),
        ([SHORT] * 20, 1),
    ],
    ids=["long", "not known yet", "short", "all short"],
)
def test_others_begin_where_the_shortest_of_the_first_is_long(seconds, threads, clock, processors):
    processors(2)
    used, first = set(), threading.Event()

    def descend(problem, z):
        used.add(threading.get_ident())
        if not first.is_set():
            first.set()
            for _ in seconds:
                problem.value(z)
            until = time.monotonic() + (PATIENCE if threads == 2 else 0.05)
            while len(used) < 2 and time.monotonic() < until:
                time.sleep(1e-3)
        return end(z)

    ends = list(descents(clock(seconds), descend, np.arange(8.0), 4, threads=2))
    assert [found.z.item() for found in ends] == [0, 1, 2, 3]
    assert len(used) == threads


@pytest.mark.parametrize(("second", "threads"), [(LONG, 2), (SHORT, 1)])
def test_what_an_earlier_search_has_seen_is_known(second, threads, processors):
    processors(2)
    known, used = stub(), set()
    known.seconds.extend([second] * 5)

    def descend(problem, z):
        used.add(threading.get_ident())
        until = time.monotonic() + (PATIENCE if threads == 2 else 0.05)
        while len(used) < 2 and time.monotonic() < until:
            time.sleep(1e-3)
        return end(z)

    list(descents(known, descend, np.arange(8.0), 4, threads=2))
    assert len(used) == threads
    assert known.seconds == [second] * 5


def test_the_record_tells_without_an_evaluation_where_it_is_long(processors):
    processors(2)
    long = stub(None, Data(np.zeros(side_by_side.MANY), None))
    ends = list(descents(long, lambda _, z: end(z), np.arange(8.0), 4, threads=2))
    assert [found.z.item() for found in ends] == [0, 1, 2, 3]


@pytest.mark.parametrize("many", [0, 10**9], ids=["at once", "one after another"])
def test_random_starts_are_begun_first(many, processors, monkeypatch):
    monkeypatch.setattr(side_by_side, "MANY", many)
    processors(2)
    made, lock = [], threading.Lock()

    def descend(problem, z):
        with lock:
            made.append(int(z))
        return end(z, np.inf if z == 2 else z)

    ends = descents(stub(), descend, np.arange(20.0), 4, threads=2)
    assert [found.z.item() for found in ends] == [0, 1, 2, 3, 4]
    assert set(made[:2]) <= {1, 2, 3}
    assert sorted(made) == [0, 1, 2, 3, 4]
    few = descents(stub(), descend, np.arange(3.0), 4, threads=2)
    assert [found.z.item() for found in few] == [0, 1, 2]


@pytest.mark.usefixtures("at_once")
def test_starts_that_lead_to_no_number_are_replaced_and_no_others_made(processors):
    processors(2)
    made = []

    def descend(problem, z):
        made.append(int(z))
        return end(z, np.inf if z in (1, 3) else 0.0)

    ends = descents(stub(), descend, np.arange(20.0), 3, threads=2)
    assert [found.z.item() for found in ends] == [0, 1, 2, 3, 4]
    assert sorted(made) == [0, 1, 2, 3, 4]


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_a_search_that_is_given_up_ends_in_every_thread(error, processors):
    processors(3)
    caller, going, ended = threading.get_ident(), threading.Semaphore(0), []

    def descend(problem, z):
        if threading.get_ident() == caller:
            if z != 0:  # the first one: two others begin meanwhile
                assert all(going.acquire(timeout=PATIENCE) for _ in range(2))
            return end(z)
        going.release()
        try:
            while True:
                problem.value(z)
        finally:
            ended.append(z)

    ends = descents(stub(), descend, np.arange(8.0), 4, threads=3)
    next(ends)
    with pytest.raises(error):
        ends.throw(error)
    until = time.monotonic() + PATIENCE
    while len(ended) < 2 and time.monotonic() < until:
        time.sleep(0.01)
    assert len(ended) == 2


@pytest.mark.parametrize("many", [0, 10**9], ids=["at once", "one after another"])
def test_an_error_of_a_descent_is_raised(many, processors, monkeypatch):
    monkeypatch.setattr(side_by_side, "MANY", many)
    processors(2)

    def descend(problem, z):
        raise ValueError(f"start {z:g}")

    with pytest.raises(ValueError, match="^start 0$"):
        list(descents(stub(), descend, np.arange(8.0), 4, threads=2))


@pytest.mark.usefixtures("at_once")
def test_an_interrupt_in_a_descent_is_raised_at_once(processors):
    processors(1)  # the calling thread has the only one
    made = []

    def descend(problem, z):
        made.append(z)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        next(descents(stub(), descend, np.arange(8.0), 4, threads=2))
    assert made[0] in (1, 2)


def test_descents_that_would_fill_the_memory_run_one_after_another(monkeypatch):
    monkeypatch.setattr(multistart, "memory", lambda: 1 << 20)
    monkeypatch.setattr(multistart.os, "cpu_count", lambda: 2)
    one = problem(bowl)
    assert multistart._threads(one) == 2
    object.__setattr__(one, "kept_bytes", 1 << 20)
    assert multistart._threads(one) == 1


def threads_of_libraries():
    found = ThreadpoolController().select(user_api="blas").info()
    return {each["num_threads"] for each in found}


def test_linear_algebra_has_one_thread_within_a_search_and_its_own_again_after_it():
    with ThreadpoolController().select(user_api="blas").limit(limits=2):
        before = threads_of_libraries()  # some libraries never have more than one
        assert 2 in before
        with blas_on_one_thread():
            assert threads_of_libraries() == {1}
            with blas_on_one_thread():  # of another search that begins meanwhile
                assert threads_of_libraries() == {1}
        assert threads_of_libraries() == before
