"""Runs that several processes solve together, and who may not join."""

import json
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

import tuner.cli.worker
from tests.tuner.helpers import Solved, snapshot, toy_study
from tuner.cli.worker import Worker, execute, joined
from tuner.data.source import Source
from tuner.run.result import read_result
from tuner.solvers import Sampler, make_solver

SMALL = ("--set", "seconds=0.2", "--set", "cutoff_hz=50", "--set", "grid=2")


def database(folder):
    return f"sqlite:///{folder / 't.db'}"


def name_of(err):
    """The name of a run, from the line that tells how to join it."""
    (line,) = [line for line in err.splitlines() if "tuner worker" in line]
    return line.split()[-1]


def test_processes_of_one_run_share_its_work(cli, here, offer, monkeypatch):
    """Two that begin at the same moment: each problem is solved once, both have the result."""
    # typer sets and deletes this variable around each command; here two threads do, in one process
    monkeypatch.setenv("PYDANTIC_DISABLE_PLUGINS", "1")
    solved, lock, together = [], threading.Lock(), threading.Barrier(2)

    def noting(name, **options):
        inner = make_solver(name, **options)

        def solve(problem):
            with lock:
                solved.append((problem.name, name))
            return inner(problem)

        return Solved(name, solve)

    offer(toy_study(solver=noting))
    url = database(here)

    def run(out):
        together.wait(60)
        from tuner.cli import invoke

        return invoke(["run", "toy", "--out", out, "--storage", url])

    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(run, ["a", "b"])) == [0, 0]
    assert len(solved) == 4
    one, other = (read_result(here / out) for out in "ab")
    assert [s.z for s in one.solutions] == [s.z for s in other.solutions]
    assert cli("run", "toy", "--out", "c")[0] == 0
    alone = read_result(here / "c")
    assert [s.z for s in alone.solutions] == [s.z for s in one.solutions]
    # A third finds it all there.
    code, _, err = cli("run", "toy", "--out", "d", "--storage", url)
    assert (code, len(solved)) == (0, 8)
    assert joined(Worker(url, name_of(err))).name == name_of(err)


def test_workers_help_and_end(cli, here, offer):
    def few(name, *, seed, starts, storage):
        if name == "tpe":
            return Sampler(name, seed=seed, storage=storage, trials=4)
        return make_solver(name, seed=seed, starts=starts, storage=storage)

    offer(toy_study(solver=few))
    url, words = database(here), ("--set", "starts=3", "--set", 'solvers=["l-bfgs-b", "tpe"]')
    code, _, err = cli("run", "toy", "--out", "a", "--storage", url, *words)
    assert code in (0, 1)
    assert execute(Worker(url, name_of(err))) == 0


def test_who_may_not_join(cli, here, offer):
    offer(toy_study())
    url = database(here)
    _, _, err = cli("run", "toy", "--out", "a", "--storage", url)
    name = name_of(err)
    code, out, err = cli("worker", "--storage", url, "--study", "toy-1")
    assert (code, out) == (2, "")
    assert err.startswith("tuner: unknown run 'toy-1'; ")
    study = toy_study()

    def plan(*given):
        return replace(study.plan(*given), source=Source("other", "1" * 64, 2, 100.0))

    offer(replace(study, plan=plan))
    code, _, err = cli("worker", "--storage", url, "--study", name)
    assert code == 2
    assert err.startswith(f"tuner: this machine has other data than the run {name}")
    code, _, err = cli("worker", "--storage", "nonsense", "--study", name)
    assert (code, len(err.splitlines())) == (2, 1)


def test_a_recipe_in_a_database_runs_no_code(here, monkeypatch):
    text = 'study = "fit"\n[settings]\nfilter = "evil.py:Evil"\n'
    monkeypatch.setattr(tuner.cli.worker, "facts_of", lambda url, name: (text, {}))
    (here / "evil.py").write_text("raise SystemExit('it ran')")
    with pytest.raises(ValueError, match="names the class evil.py:Evil of a Python file, and no"):
        joined(Worker(database(here), "fit-1"))


def test_what_is_refused_elsewhere_is_refused_here(cli, here, offer):
    def failing(name, **options):
        def solve(problem):
            raise ValueError("this cannot be solved")

        return Solved(name, solve)

    offer(toy_study(solver=failing))
    code, out, err = cli("run", "toy", "--out", "a", "--storage", database(here))
    assert (code, out) == (2, "")
    assert err.splitlines()[-1] == "tuner: this cannot be solved"


def test_a_run_that_lost_its_database_goes_on(cli, here, offer):
    def losing(name, **options):
        inner = make_solver(name, **options)

        def solve(problem):
            if problem.name == "side":
                from tuner.trials.database import DatabaseError

                raise DatabaseError("the database of --storage cannot be used: it went away")
            return inner(problem)

        return Solved(name, solve)

    offer(toy_study(solver=losing))
    words = ("run", "toy", "--out", "a", "--storage", database(here))
    code, _, err = cli(*words)
    assert code == 2
    assert err.splitlines()[-1].startswith(
        "tuner: the database of --storage cannot be used: it went away; finished parts are saved; "
        "go on with: tuner run a/study.toml --out a --resume --storage ..."
    )
    kept = json.loads((here / "a" / "progress.json").read_text())["finished"]
    assert len(kept) == 2
    offer(toy_study())
    assert cli(*words, "--resume")[0] == 0


def test_jobs_are_processes_that_change_no_number(cli, here):
    few = ("--set", "starts=2", "--set", 'solvers=["l-bfgs-b"]', "--claim", "gyro.q_over_r")
    words = ("run", "kownacki2010", *SMALL, *few)
    assert cli(*words, "--jobs", 2, "--out", "two")[0] in (0, 1)
    assert cli(*words, "--jobs", 1, "--out", "one")[0] in (0, 1)
    one, two = (read_result(here / out) for out in ("one", "two"))
    for a, b in zip(one.solutions, two.solutions, strict=True):
        assert key(a) == key(b)
        assert a.z == b.z
        assert a.evaluations == b.evaluations
    assert set(snapshot(here / "two")) - set(snapshot(here / "one")) == {"trials.sqlite3"}


def key(record):
    return record.problem, record.solver


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL to send")
def test_workers_end_with_the_process_that_started_them(here):
    """They are told by a pipe, which no way of dying leaves open."""
    code = (
        "import sys\n"
        "from tuner.run.shared_run import workers\n"
        "import tuner.run.shared_run, subprocess\n"
        "real = subprocess.Popen\n"
        "def popen(command, **options):\n"
        "    at = command.index('-c') + 2\n"
        "    started = real([*command[:at - 1], 'import sys; sys.stdin.read()'], **options)\n"
        "    print(started.pid, flush=True)\n"
        "    return started\n"
        "subprocess.Popen = popen\n"
        "with workers(1, 'sqlite://', 'none', ()):\n"
        "    sys.stdin.read()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    worker = int(process.stdout.readline())
    process.send_signal(signal.SIGKILL)
    process.communicate()
    for _ in range(200):
        if not _lives(worker):
            return
        threading.Event().wait(0.05)
    pytest.fail("the worker lives on")


def _lives(pid):
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
