"""Exit codes of runs, what goes where, and the command line as a process."""

import json
import os
import subprocess
import sys

import pytest

from tests.tuner.helpers import Solved, snapshot, toy_study
from tuner.cli import invoke
from tuner.run.result import read_result
from tuner.solvers import Sampler


def process(cache, *arguments):
    """The command line as an installed program would run it."""
    code = "import sys; from tuner.cli import main; sys.argv[0] = 'tuner'; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "TUNER_CACHE": str(cache)},
    )


def test_a_run_that_converged(cli, here, toy):
    code, out, err = cli("run", "toy", "--json")
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert next(iter(result)) == "schema"
    folder = here / "runs" / "toy-001"
    assert out == (folder / "result.json").read_text()
    assert set(result["artifacts"]) == {n for n, d in snapshot(folder).items() if d is not None}
    assert [s["status"] for s in result["solutions"]] == ["converged"] * 4


@pytest.mark.parametrize("objective", ["slope", "hollow"])
def test_a_run_that_did_not_converge(cli, here, toy, objective):
    words = ("--set", f"objective={objective}", "--out", "out")
    code, out, err = cli("run", "toy", "--json", *words)
    assert (code, err) == (1, "")
    result = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert result["exports"] == []
    assert not (here / "out" / "exports").exists()
    assert read_result(here / "out").study == "toy"
    code, out, err = cli("run", "toy", *words, "--force")
    assert (code, err) == (1, "")
    assert {"slope": "at bound", "hollow": "failed"}[objective] in out


@pytest.mark.parametrize("objective", ["slope", "hollow"])
def test_what_did_not_converge_is_exported_by_force_only(cli, here, toy, objective):
    cli("run", "toy", "--set", f"objective={objective}", "--out", "out")
    before = snapshot(here)
    code, out, err = cli("export", "out", "--to", "csv")
    assert (code, out) == (2, "")
    status = {"slope": "at bound", "hollow": "failed"}[objective]
    assert err == (
        f"tuner: the solution of toy is {status!r}, not converged; --force exports it anyway\n"
    )
    assert snapshot(here) == before
    assert cli("export", "out", "--to", "csv", "--force")[0] == 0
    assert (here / "toy.csv").is_file()
    # The score of what failed is infinite: null on file, and the file can still be read.
    (record,) = read_result(here / "out").exports
    assert (record.score is None) == (objective == "hollow")
    assert cli("compare", "out")[0] in (0, 1)


def test_export_adds_its_score_to_the_result(cli, here, toy):
    cli("run", "toy", "--out", "out")
    before = read_result(here / "out")
    code, out, err = cli("export", "out", "--to", "toml", "-o", "mine.toml")
    assert (code, out) == (0, "")
    assert [line.split(":")[0] for line in err.splitlines()] == [
        "wrote mine.toml",
        "read back and scored",
    ]
    after = read_result(here / "out")
    *old, new = after.exports
    assert old == before.exports
    assert (new.problem, new.format, new.file) == ("toy", "toml", "mine.toml")
    assert new.score == pytest.approx(1.0, abs=1e-8)  # the bowl's lowest value
    assert after.model_copy(update={"exports": old}).to_json() == before.to_json()


def test_comparison_decides_its_exit_code(cli, here, toy):
    """toy.lowest is 1 against 1.25 on paper, toy.b_over_a is right, the third row is in words."""
    cli("run", "toy", "--out", "out")
    code, out, err = cli("compare", "out", "--csv")
    assert (code, err) == (1, "")
    lines = out.splitlines()
    assert lines[0] == "quantity,where,unit,paper,ours,verdict,note"
    assert lines[1].startswith("toy.b_over_a,Table 1,,0.135335,0.1353")
    assert lines[2].startswith("toy.lowest,equation (1),m,1.25,1,differs,-20.0 %")
    assert lines[3] == "toy.known,section 2,,-,-,claim holds,a row | in words"
    assert cli("compare", "out", "--tol", "25%")[0] == 0
    assert cli("compare", "out", "--tol", "0.1999")[0] == 1
    assert cli("compare", "out", "--tol", "0.2001")[0] == 0
    assert cli("compare", "out", "--tol", "0")[0] == 1


def test_comparison_judges_by_the_tolerance_that_was_given(cli, here, toy):
    cli("run", "toy", "--out", "out")
    out = cli("compare", "out", "--tol", "25%", "--json")[1]
    document = json.loads(out)
    assert document["schema"] == "tuner.compare/1"
    ((entry,), rows) = document["runs"], document["runs"][0]["rows"]
    assert (entry["run"], entry["study"]) == ("out", "toy")
    assert [row["within"] for row in rows] == [True, True, True]
    assert [row["verdict"] for row in rows] == ["match", "differs", "claim holds"]
    rows = json.loads(cli("compare", "out", "--json")[1])["runs"][0]["rows"]
    assert [row["within"] for row in rows] == [True, False, True]
    assert (
        "| toy.lowest | equation (1) | m | 1.25 | 1 | match |"
        in (cli("compare", "out", "--tol", "25%", "--md")[1])
    )


def test_markdown_keeps_its_columns(cli, here, toy):
    cli("run", "toy", "--out", "out")
    lines = cli("compare", "out", "--md")[1].splitlines()
    assert lines[1] == "| --- | --- | --- | --- | --- | --- | --- |"
    assert lines[-1].endswith("| a row \\| in words |")


def test_two_runs_side_by_side(cli, here, toy):
    cli("run", "toy", "--out", "one")
    cli("run", "toy", "--out", "two", "--set", "objective=slope")
    code, out, _ = cli("compare", "one", "two", "--csv")
    assert code == 1
    header, *rows = [line.split(",") for line in out.splitlines()]
    assert header == ["quantity", "where", "unit", "paper", "one", "verdict", "two", "verdict"]
    assert rows[0][5:] == ["match", "7.38906", "differs"]  # slope: exp(-1 + 3)


def test_a_study_that_takes_no_log(cli, here, offer):
    from dataclasses import replace

    offer(replace(toy_study(), channels={}))
    assert cli("run", "toy", "--log", "x.csv", "--map", "x=g") == (
        2,
        "",
        "tuner: toy takes no log\n",
    )


def test_an_error_while_solving_is_told_in_one_line(cli, here, offer):
    def failing(name, **options):
        def solve(problem):
            raise ValueError("this cannot\nbe solved")

        return Solved(name, solve)

    offer(toy_study(solver=failing))
    assert cli("run", "toy") == (2, "", "tuner: this cannot be solved\n")


def test_debugging_shows_the_traceback(here, toy, monkeypatch):
    monkeypatch.setenv("TUNER_DEBUG", "1")
    with pytest.raises(ValueError, match="no such file"):
        invoke(["run", "toy", "--log", "nowhere.csv", "--map", "x=g"])


def test_samplers_of_one_run_share_its_database(cli, here, offer):
    def few(name, *, seed, starts, storage):
        return Sampler(name, seed=seed, storage=storage, trials=2)

    offer(toy_study(solver=few))
    words = ("--set", 'solvers=["cma-es", "tpe"]', "--jobs", 4, "--out", "out")
    code, _, err = cli("run", "toy", *words)
    assert (code, err) == (1, "")
    assert (here / "out" / "trials.sqlite3").is_file()
    assert [s.evaluations for s in read_result(here / "out").solutions] == [2] * 4


def test_a_database_that_cannot_be_used(cli, here, toy):
    words = ("--set", 'solvers=["tpe"]', "--storage", "sqlite:////no/such/folder/x")
    code, out, err = cli("run", "toy", *words)
    assert (code, out) == (2, "")
    assert err.startswith("tuner: the database of --storage cannot be used: ")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["run", "toy", "--seed", "-1"], "--seed"),
        (["run", "toy", "--seed", "4294967296"], "--seed"),
        (["run", "toy", "--seed", "one"], "--seed"),
        (["run", "toy", "--jobs", "0"], "--jobs"),
        (["run", "toy", "--rate", "fast"], "--rate"),
        (["run", "toy", "--set", "=3"], "unknown setting ''"),
        (["run", "toy", "--set", "starts=many"], "setting starts"),
        (["run"], "Missing argument"),
        (["runn"], "run"),
        (["export", "out"], "--to"),
        (["compare"], "Missing argument"),
        (["--nonsense"], "--nonsense"),
    ],
)
def test_usage_errors_are_one_line(cli, here, toy, arguments, word):
    code, out, err = cli(*arguments)
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith("tuner: ")
    assert word in err
    assert snapshot(here) == {}


# The command line as a process of its own.


def test_process_help(cache):
    ran = process(cache, "--help")
    assert (ran.returncode, ran.stderr) == (0, "")
    for command in ("list", "run", "compare", "export", "doctor"):
        assert f"\n  {command} " in ran.stdout


def test_process_refuses_in_one_line(cache, here):
    ran = process(cache, "run", "kownacki2010", "--set", "R=-1")
    assert (ran.returncode, ran.stdout) == (2, "")
    assert ran.stderr == "tuner: setting R: Input should be greater than 0, got -1\n"
    assert snapshot(here) == {}


def test_process_survives_a_closed_pipe(cache, here):
    code = "import sys; from tuner.cli import main; sys.argv[0] = 'tuner'; main()"
    shell = f"{sys.executable!r} -c {code!r} list formats --json | true"
    ran = subprocess.run(
        ["sh", "-c", shell], capture_output=True, text=True, check=False, env={**os.environ}
    )
    assert "Traceback" not in ran.stderr
