"""Descents from several starts at the same time: the same ends, and none that goes on alone."""

import threading
import time
from dataclasses import replace
from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

from tests.tuner.helpers import bowl, crater, problem
from tuner.solvers import multistart, side_by_side
from tuner.solvers.blas import blas_on_one_thread
from tuner.solvers.gradient import Gradient
from tuner.solvers.minimum import Minimum
from tuner.solvers.nelder_mead import NelderMead
from tuner.solvers.side_by_side import descents

PATIENCE = 30  # s


def end(z, value=1.0):
    return Minimum(np.atleast_1d(z), float(value), 1, True, "")


@pytest.mark.parametrize("alone", [0.0, 1e9], ids=["at once", "as they are short"])
@pytest.mark.parametrize("solver", [Gradient("l-bfgs-b", seed=1, starts=4), NelderMead(1, 4)])
@pytest.mark.parametrize("objective", [bowl, crater], ids=["bowl", "first start is lost"])
def test_ends_are_those_of_one_thread(solver, objective, alone, monkeypatch):
    monkeypatch.setattr(side_by_side, "ALONE", alone)
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


def test_long_descents_run_at_the_same_time(monkeypatch):
    monkeypatch.setattr(side_by_side, "ALONE", 0.0)
    together = threading.Barrier(2)

    def descend(problem, z):
        together.wait(PATIENCE)
        return end(z)

    ends = descents(problem(bowl), descend, np.arange(8.0), 4, threads=2)
    assert [found.z.item() for found in islice(ends, 4)] == [0, 1, 2, 3]


@pytest.mark.parametrize(("seconds", "count"), [(2e-3, 1), (4e-4, 2)])
def test_others_begin_once_long_evaluations_have_taken_a_while(seconds, count, monkeypatch):
    monkeypatch.setattr(side_by_side, "ALONE", 2 * PATIENCE)
    together = threading.Barrier(2)
    slow = SimpleNamespace(known_starts=(), value=lambda z: time.sleep(seconds))

    def descend(problem, z):
        for _ in range(count):
            problem.value(z)
        together.wait(PATIENCE)
        return end(z)

    ends = descents(slow, descend, np.arange(8.0), 4, threads=2)
    assert [found.z.item() for found in islice(ends, 4)] == [0, 1, 2, 3]


@pytest.mark.parametrize(("threads", "descending"), [(2, 2), (3, 3), (64, 4)])
def test_threads_start_before_the_first_descent_and_no_more_than_descents(threads, descending):
    beside = []

    def descend(problem, z):
        pool = "".join(threading.current_thread().name.rpartition("_")[:2])
        beside.append(sum(each.name.startswith(pool) for each in threading.enumerate()))
        return end(z)

    list(descents(problem(bowl), descend, np.arange(4.0), 4, threads))
    assert beside == [descending] * 4


@pytest.mark.parametrize("alone", [0.0, PATIENCE], ids=["at once", "one after another"])
def test_random_starts_are_begun_first(alone, monkeypatch):
    monkeypatch.setattr(side_by_side, "ALONE", alone)
    made, lock = [], threading.Lock()

    def descend(problem, z):
        with lock:
            made.append(int(z))
        return end(z, np.inf if z == 2 else z)

    ends = descents(problem(bowl), descend, np.arange(20.0), 4, threads=2)
    assert [found.z.item() for found in islice(ends, 5)] == [0, 1, 2, 3, 4]
    assert made[0] == 1
    assert sorted(made) == [0, 1, 2, 3, 4]
    few = descents(problem(bowl), descend, np.arange(3.0), 4, threads=2)
    assert [found.z.item() for found in few] == [0, 1, 2]


def test_short_descents_run_one_after_another(monkeypatch):
    monkeypatch.setattr(side_by_side, "ALONE", PATIENCE)
    running, most = set(), []

    def descend(problem, z):
        running.add(z)
        most.append(len(running))
        running.discard(z)
        return end(z)

    found = list(islice(descents(problem(bowl), descend, np.arange(8.0), 4, threads=4), 4))
    assert most == [1] * len(found) == [1] * 4


def test_starts_that_lead_to_no_number_are_replaced_and_no_others_made(monkeypatch):
    monkeypatch.setattr(side_by_side, "ALONE", 0.0)
    made = []

    def descend(problem, z):
        made.append(int(z))
        return end(z, np.inf if z in (1, 3) else 0.0)

    ends = descents(problem(bowl), descend, np.arange(20.0), 3, threads=2)
    assert [found.z.item() for found in islice(ends, 5)] == [0, 1, 2, 3, 4]
    assert sorted(made) == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_a_search_that_is_given_up_ends_in_every_thread(error, monkeypatch):
    monkeypatch.setattr(side_by_side, "ALONE", 0.0)
    ended = []
    going = {1: threading.Event(), 2: threading.Event()}

    def descend(problem, z):
        if z == 0:
            assert all(each.wait(PATIENCE) for each in going.values())
            return end(z)
        try:
            while True:
                problem.value(np.zeros(2))
                going[z].set()
        finally:
            ended.append(z)

    ends = descents(problem(bowl), descend, np.arange(8.0), 3, threads=3)
    next(ends)
    with pytest.raises(error):
        ends.throw(error)
    until = time.monotonic() + PATIENCE
    while len(ended) < len(going) and time.monotonic() < until:
        time.sleep(0.01)
    assert sorted(ended) == [1, 2]


def test_an_error_of_a_descent_is_raised(monkeypatch):
    monkeypatch.setattr(side_by_side, "ALONE", 0.0)

    def descend(problem, z):
        raise ValueError(f"start {z:g}")

    with pytest.raises(ValueError, match="^start 0$"):
        list(descents(problem(bowl), descend, np.arange(8.0), 4, threads=2))


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
