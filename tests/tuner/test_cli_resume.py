"""Interrupted runs: exit code 130, everything saved, and a command that goes on."""

import contextlib
import json
import os
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.tuner.helpers import Solved, snapshot, toy_study, write_csv
from tuner.cli.interrupt import interruptible
from tuner.run.result import read_result
from tuner.run.study import Claim
from tuner.solvers import make_solver
from tuner.stop import code_of

GO_ON = "tuner: finished parts are saved; go on with:\ntuner "


class Interrupted:
    """Makes solvers of which one is interrupted, until it is told to stop doing so."""

    def __init__(self, at):
        self.at = at
        self.solved = []

    def __call__(self, name, **options):
        solver = make_solver(name, **options)

        def solve(problem):
            if (problem.name, name) == self.at:
                raise KeyboardInterrupt
            self.solved.append((problem.name, name))
            return solver(problem)

        return Solved(name, solve)


def comparable(folder):
    """A finished run without the times it took."""
    plain = json.loads(read_result(folder).to_json())
    for solution in plain["solutions"]:
        solution["seconds"] = 0
    return plain | {"seconds": 0}


@pytest.fixture
def interrupted(offer):
    """Offer the toy study with a solver that is interrupted at a task."""

    def study(*at):
        solver = Interrupted(at)
        offer(toy_study(solver=solver))
        return solver

    return study


def test_the_printed_command_resumes_to_the_same_result(cli, here, interrupted):
    solver = interrupted("side", "nelder-mead")
    code, out, err = cli("run", "toy", "--out", "a run's", "--jobs", 1, "--seed", 5)
    assert (code, out) == (130, "")
    assert err.startswith(GO_ON)
    assert err.count("\n") == 2
    assert set(snapshot(here / "a run's")) == {"study.toml", "environment.json", "progress.json"}
    # The one worker may have begun the next task by the time it is called off.
    assert solver.solved[:2] == [("toy", "nelder-mead"), ("toy", "l-bfgs-b")]
    solver.at, solver.solved = None, []
    words = shlex.split(err.removeprefix(GO_ON))
    assert words == ["run", "a run's/study.toml", "--out", "a run's", "--resume"]
    assert cli(*words)[0] == 0
    assert sorted(solver.solved) == [("side", "l-bfgs-b"), ("side", "nelder-mead")]
    assert not (here / "a run's" / "progress.json").exists()
    assert cli("run", "toy", "--out", "whole", "--seed", 5)[0] == 0
    assert comparable(here / "a run's") == comparable(here / "whole")
    files = [snapshot(here / name) for name in ("a run's", "whole")]
    for name in files[1].keys() - {"result.json", "report.html"}:  # they tell how long it took
        assert files[0][name] == files[1][name]
    assert files[0].keys() == files[1].keys()


def test_interruption_at_the_very_first_task_can_be_resumed(cli, here, interrupted):
    solver = interrupted("toy", "nelder-mead")
    code, _, err = cli("run", "toy", "--jobs", 1)
    assert code == 130
    solver.at = None
    code, _, _ = cli(*shlex.split(err.strip().removeprefix(GO_ON)))
    assert code == 0
    assert (here / "runs" / "toy-001" / "result.json").is_file()
    assert not (here / "runs" / "toy-002").exists()


def test_interruption_before_the_first_task_can_be_resumed(cli, here, interrupted, monkeypatch):
    interrupted("none", "none")
    with monkeypatch.context() as patch:
        patch.setattr("tuner.run.pipeline.environment", interrupt)
        code, _, err = cli("run", "toy", "--out", "out")
    assert (code, set(snapshot(here / "out"))) == (130, {"study.toml"})
    assert cli(*shlex.split(err.strip().removeprefix(GO_ON)))[0] == 0
    with monkeypatch.context() as patch:
        patch.setattr("tuner.cli.run.RunFolder.write", interrupt)
        code, _, err = cli("run", "toy", "--out", "none")
    assert (code, err) == (130, "tuner: interrupted before anything was saved\n")
    assert not (here / "none").exists()


def interrupt(*_):
    raise KeyboardInterrupt


def test_an_interrupted_run_of_a_log_names_the_log(cli, here, interrupted):
    solver = interrupted("side", "l-bfgs-b")
    (here / "my logs").mkdir()
    log = write_csv(here / "my logs" / "rest.csv", np.arange(50) / 10, np.sin(np.arange(50.0)))
    words = ("run", "toy", "--log", log, "--map", "x=g", "--out", "out")
    code, _, err = cli(*words, "--jobs", 1)
    assert code == 130
    solver.at = None
    last = err.splitlines()[-1]
    code, _, err = cli(*shlex.split(last.removeprefix("tuner ")))
    assert code == 0, err
    assert read_result(here / "out").log.name == "rest.csv"
    # The folder itself knows nothing of where the log lies.
    assert b"my logs" not in (here / "out" / "study.toml").read_bytes()


def test_the_same_words_with_resume_go_on_as_well(cli, here, interrupted):
    solver = interrupted("side", "l-bfgs-b")
    words = ("run", "toy", "--out", "out", "--set", "starts=3")
    assert cli(*words, "--jobs", 1)[0] == 130
    solver.at, solver.solved = None, []
    assert cli(*words, "--resume")[0] == 0
    assert solver.solved == [("side", "l-bfgs-b")]


def test_a_run_of_a_claim_goes_on_as_one(cli, here, interrupted):
    solver = interrupted("toy", "l-bfgs-b")
    code, _, err = cli("run", "toy", "--claim", "toy.lowest", "--out", "out", "--jobs", 1)
    assert code == 130
    solver.at, solver.solved = None, []
    assert cli(*shlex.split(err.strip().removeprefix(GO_ON)))[0] == 0
    assert solver.solved == [("toy", "l-bfgs-b")]
    assert [row.quantity for row in read_result(here / "out").comparisons] == ["toy.lowest"]


@pytest.mark.parametrize(
    "words",
    [
        ("--set", "starts=4"),
        ("--seed", 1),
        ("--set", 'solvers=["tpe"]'),
        ("--claim", "toy.lowest"),
    ],
    ids=str,
)
def test_other_settings_cannot_be_mixed_into_a_run(cli, here, interrupted, words):
    solver = interrupted("side", "l-bfgs-b")
    assert cli("run", "toy", "--out", "out", "--jobs", 1)[0] == 130
    solver.at = None
    before = snapshot(here)
    code, out, err = cli("run", "toy", "--out", "out", "--resume", *words)
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith("tuner: --resume: out/study.toml has other settings or claims")
    assert snapshot(here) == before


def test_another_log_cannot_be_mixed_into_a_run(cli, here, interrupted):
    solver = interrupted("side", "l-bfgs-b")
    log = write_csv(here / "rest.csv", np.arange(50) / 10, np.sin(np.arange(50.0)))
    assert cli("run", "toy", "--log", log, "--map", "x=g", "--out", "out", "--jobs", 1)[0] == 130
    solver.at = None
    write_csv(log, np.arange(50) / 10, np.cos(np.arange(50.0)))
    code, _, err = cli("run", "out/study.toml", "--out", "out", "--resume")
    assert code == 2
    assert "rest.csv is not the log of study.toml: its SHA-256 differs" in err
    code, _, err = cli("run", "out/study.toml", "--out", "out", "--resume", "--log", log)
    assert code == 2
    assert "another seed or log" in err


def test_a_damaged_progress_file_is_told(cli, here, interrupted):
    solver = interrupted("side", "l-bfgs-b")
    assert cli("run", "toy", "--out", "out", "--jobs", 1)[0] == 130
    solver.at = None
    (here / "out" / "progress.json").write_text("[{")
    code, _, err = cli("run", "toy", "--out", "out", "--resume")
    assert code == 2
    assert err == "tuner: progress.json is not that of a run; start again with --force\n"
    assert cli("run", "toy", "--out", "out", "--force")[0] == 0


def test_a_finished_run_cannot_be_resumed(cli, here, toy):
    assert cli("run", "toy", "--out", "out")[0] == 0
    before = snapshot(here)
    code, _, err = cli("run", "toy", "--out", "out", "--resume")
    assert code == 2
    assert err == "tuner: --resume needs --out with the folder of an interrupted run\n"
    assert snapshot(here) == before


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGINT to send")
def test_ctrl_c_is_heard_at_the_next_step_where_python_drops_it(cli, here, offer):
    """As it does in a callback of the garbage collector."""
    study = toy_study()

    def plan(*given):
        made = study.plan(*given)

        def rows(case, solutions):
            with contextlib.suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            return ()

        return replace(made, claims=(Claim("lost", rows),))

    offer(replace(study, plan=plan))
    handler = signal.getsignal(signal.SIGINT)
    # Threads that write exports go on where the process does: not into the next test's folder.
    code, out, err = cli("run", "toy", "--out", here / "out")
    assert (code, out) == (130, "")
    assert err.startswith(GO_ON)
    assert not (here / "out" / "result.json").exists()
    assert signal.getsignal(signal.SIGINT) is handler


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGTERM to send")
def test_a_signal_in_an_import_of_a_run_waits_for_its_end(tmp_path, monkeypatch):
    (tmp_path / "slow.py").write_text("import signal\nsignal.raise_signal(signal.SIGTERM)\n")
    monkeypatch.syspath_prepend(tmp_path)
    with interruptible(), pytest.raises(KeyboardInterrupt) as stopped:  # noqa: PT012
        import slow  # noqa: F401

        time.sleep(9)
    assert code_of(stopped.value) == 143


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGINT to send")
def test_ctrl_c(cache, here):
    """A real process and a real signal, once its first solution is saved."""
    words = ["run", "kownacki2010", "--out", "out", "--jobs", "1", "--set", "starts=2"]
    words += ["--set", "seconds=2", "--set", "rate_hz=1000", "--set", "grid=2"]
    code = "import sys; from tuner.cli import invoke; sys.exit(invoke(sys.argv[1:]))"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "TUNER_CACHE": str(cache)},
    )
    progress, until = Path("out/progress.json"), time.monotonic() + 120
    while not (progress.exists() and json.loads(progress.read_text())["finished"]):
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 130
    assert out == ""
    assert GO_ON in err
    assert "Traceback" not in err
    assert set(snapshot(here / "out")) >= {"study.toml", "environment.json", "progress.json"}
    assert not Path("out/result.json").exists()
