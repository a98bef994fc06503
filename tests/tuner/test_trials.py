"""Trials that several processes make: exact totals, lost processes, lost databases."""

import contextlib
import sqlite3
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import optuna
import pytest
from optuna.trial import TrialState

import tuner.trials.database
import tuner.trials.search
from tests.postgres import server
from tests.tuner.helpers import bowl, problem
from tuner.problem.constraint import Constraint
from tuner.problem.parameters import Limited
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers import Ipopt, NelderMead, Sampler
from tuner.solvers.starts import SharedStarts
from tuner.trials.database import DatabaseError, merge_log, without_password
from tuner.trials.numbered import Numbered
from tuner.trials.search import opened


@pytest.fixture(scope="module")
def postgres():
    with server() as url:
        yield url


@pytest.fixture(params=["sqlite", "postgres"])
def url(request, tmp_path):
    """A new SQLite file, or the server."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 't.db'}"
    return request.getfixturevalue("postgres")


@pytest.fixture
def impatient(monkeypatch):
    """Processes count as lost at once."""
    monkeypatch.setattr(tuner.trials.database, "GRACE", 1)
    monkeypatch.setattr(tuner.trials.search, "HEARTBEAT", 0.3)


@pytest.fixture
def search(url, request):
    """Open a search of this test's own."""

    def enter(total, **options):
        sampler = Numbered(optuna.samplers.RandomSampler, 0)
        return opened(url, request.node.name, total, sampler, {}, **options)

    return enter


def states(trials):
    return [t.state for t in trials.study.get_trials(deepcopy=False)]


def draw(trial):
    return trial.suggest_float("x", 0.0, 1.0)


def test_totals_are_exact_however_many_search(search):
    """All open the new database, and all ask, at the same moment."""
    together = threading.Barrier(4)

    def work(_):
        together.wait(60)
        with search(10, first={"x": 0.5}) as trials:
            return trials.work(draw)

    with ThreadPoolExecutor(4) as pool:
        made = list(pool.map(work, range(4)))
    assert sum(made) == 10
    with search(10) as trials:
        found = trials.complete()
        assert len(found) == 10
        assert not {TrialState.RUNNING, TrialState.WAITING} & {*states(trials)}
        # One process alone began, and it entered the first point once.
        assert [t.params["x"] for t in found].count(0.5) == 1
        assert len({t.params["x"] for t in found}) == 10  # none is drawn twice
        assert trials.work(draw) == 0
    with search(12) as trials:  # more are asked for later
        assert trials.work(draw) == 2


def test_a_lost_process_loses_no_trial(search, impatient):
    with search(3) as lost:
        trial = lost.study.ask()  # and it is never heard of again
        x = draw(trial)
    with search(3) as trials:
        assert trials.work(draw) == 3
        found = trials.complete()
        assert x in [t.params["x"] for t in found]
        assert states(trials).count(TrialState.FAIL) == 1
        # It wakes up, too late.
        trials._tell(trial, 7.0)
        assert [t.value for t in trials.complete()] == [t.value for t in found]


def test_a_process_that_works_for_long_is_not_taken_for_lost(search, impatient):
    def slow(trial):
        time.sleep(2.5)
        return draw(trial)

    with search(1) as first, ThreadPoolExecutor(1) as pool:
        working = pool.submit(first.work, slow)
        time.sleep(0.5)
        with search(1) as other:
            assert other.work(draw) == 0
        assert working.result() == 1
        assert states(first) == [TrialState.COMPLETE]


def test_an_interrupted_trial_is_made_again_at_its_point(search):
    seen = []

    def interrupted(trial):
        seen.append(draw(trial))
        if len(seen) == 2:
            raise KeyboardInterrupt
        return seen[-1]

    with search(3) as trials:
        with pytest.raises(KeyboardInterrupt):
            trials.work(interrupted)
        assert states(trials) == [TrialState.COMPLETE, TrialState.FAIL, TrialState.WAITING]
        assert trials.work(interrupted) == 2
        assert seen[1] == seen[2]


def test_an_error_of_the_objective_comes_through(search):
    def failing(trial):
        raise ZeroDivisionError("mine")

    with search(3) as trials:
        with pytest.raises(ZeroDivisionError, match="mine"):
            trials.work(failing)
        assert states(trials) == [TrialState.FAIL]


def test_marked_trials_are_made_once_each(search):
    marks = [{"part": i} for i in range(4)]
    with search(4, marks=marks) as one, search(4, marks=marks) as other:
        seen = []

        def part(trial):
            seen.append(trial.user_attrs["part"])
            return 0.0

        assert one.make_one(part)
        assert other.make_one(part)
        assert one.work(part) == 2
        assert not other.make_one(part)
        assert sorted(seen) == [0, 1, 2, 3]


def test_a_database_that_dies_is_told_in_one_sentence(search, monkeypatch):
    from sqlalchemy.exc import OperationalError

    lost = OperationalError("select", {}, Exception("server closed the connection\nunexpectedly"))

    def fail(*_, **__):
        raise lost

    with search(3) as trials:
        assert trials.make_one(draw)
        monkeypatch.setattr(trials.storage, "set_trial_state_values", fail)
        with pytest.raises(DatabaseError, match="cannot be used: server closed the connection$"):
            trials.work(draw)


def test_shared_starts_end_where_others_do(url):
    posed, alone = problem(bowl), NelderMead(seed=2, starts=3)
    shared = NelderMead(seed=2, starts=3, shared=SharedStarts(url, "nelder-mead"))
    with ThreadPoolExecutor(2) as pool:
        made = pool.submit(shared.help, posed), pool.submit(shared.help, posed)
        assert sum(each.result() for each in made) == 3
    one, other = alone(posed), shared(posed)
    assert one.z.tobytes() == other.z.tobytes()
    assert one.evaluations == other.evaluations
    assert one.certificate == other.certificate


def curved():
    """Two numbers on a line: without a time loop, so that CasADi takes it as symbols."""
    space = Space.of(x=Limited(1.0, -10.0, 10.0), y=Limited(-2.0, -10.0, 10.0))
    line = Constraint("line", lambda p, _: 1.0 - p["x"] - p["y"], 0.0)

    def cost(p, _):
        return 1.0 + p["x"] ** 2 + p["y"] ** 4

    return Problem("curved", space, None, lambda values: values, cost, constraints=(line,))


@pytest.mark.parametrize("posed", [curved(), problem(bowl)], ids=["symbols", "callbacks"])
def test_shared_starts_of_ipopt_end_where_others_do(tmp_path, posed):
    alone = Ipopt(seed=2, starts=3)
    shared = replace(alone, shared=SharedStarts(f"sqlite:///{tmp_path / 't.db'}", repr(alone)))
    assert [shared.help(posed), shared.help(posed), alone.help(posed)] == [3, 0, 0]
    one, other = alone(posed), shared(posed)
    assert one.z.tobytes() == other.z.tobytes()
    assert one.evaluations == other.evaluations
    assert one.certificate == other.certificate


def test_starts_that_are_lost_are_drawn_again(url, monkeypatch):
    posed, value = problem(bowl), Problem.value

    def holed(self, z):
        return np.inf if (np.abs(z) < 1e-9).all() else value(self, z)

    monkeypatch.setattr(Problem, "value", holed)
    options = {"seed": 2, "starts": 2, "evaluations": 20}
    one = NelderMead(**options)(posed)
    other = NelderMead(**options, shared=SharedStarts(url, "holed"))(posed)
    assert one.z.tobytes() == other.z.tobytes()
    assert one.certificate.starts == other.certificate.starts


def test_a_search_on_a_server(postgres):
    found = Sampler("cma-es", seed=4, storage=postgres, trials=6)(problem(bowl))
    alone = Sampler("cma-es", seed=4, trials=6)(problem(bowl))
    assert found.z.tobytes() == alone.z.tobytes()


def test_no_password_is_shown():
    url = "postgresql://me:secret@host.invalid/base"
    assert without_password(url) == "postgresql://me:***@host.invalid/base"
    with pytest.raises(DatabaseError) as raised:
        Sampler("tpe", seed=0, storage=f"{url}?connect_timeout=1", trials=1)(problem(bowl))
    assert "secret" not in str(raised.value)
    assert "\n" not in str(raised.value)


def test_the_log_of_a_killed_process_is_brought_into_its_file(tmp_path):
    file = tmp_path / "trials.sqlite3"
    code = (
        "import os, sqlite3, sys\n"
        "file = sqlite3.connect(sys.argv[1])\n"
        "file.execute('PRAGMA journal_mode=WAL')\n"
        "file.execute('create table kept (n)')\n"
        "file.execute('insert into kept values (7)')\n"
        "file.commit()\n"
        "os._exit(0)\n"
    )
    subprocess.run([sys.executable, "-c", code, file], check=True)
    assert Path(f"{file}-wal").exists()
    merge_log(f"sqlite:///{file}")
    assert [each.name for each in tmp_path.iterdir()] == [file.name]
    with contextlib.closing(sqlite3.connect(file)) as left:
        assert left.execute("select n from kept").fetchall() == [(7,)]
