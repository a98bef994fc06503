"""Exit codes of runs, what goes where, and the command line as a process."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.tuner.helpers import Solved, snapshot, toy_study, write_csv
from tuner import export
from tuner.run.recipe import read_recipe
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
    assert read_result(here / "out").exports == []  # what a run exported itself
    assert export.load((here / "toy.csv").read_bytes(), "csv").provenance.status == status
    assert cli("compare", "out")[0] in (0, 1)


def test_an_export_leaves_the_run_as_it_is(cli, here, toy):
    cli("run", "toy", "--out", "out")
    before = snapshot(here / "out")
    code, out, err = cli("export", "out", "--to", "toml", "-o", "mine.toml")
    assert (code, out) == (0, "")
    assert err == "wrote mine.toml: 3 quantities, read back equal\n"
    assert (here / "mine.toml").read_bytes() == (here / "out/exports/toy.toml").read_bytes()
    assert snapshot(here / "out") == before


def damaging(monkeypatch, suffix, old, new):
    """Make files differ from what they should hold, as a bad disk would."""
    whole = Path.read_bytes

    def damaged(path):
        data = whole(path)
        return data.replace(old, new) if path.suffix == suffix else data

    monkeypatch.setattr(Path, "read_bytes", damaged)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (b'unit = "m"', b'unit = "k"', "mine.toml does not hold what was written; the disk may"),
        (b"[", b"(", "no tuned filter can be read as toml"),
    ],
    ids=["another unit", "no TOML"],
)
def test_a_damaged_export_is_noticed(cli, here, toy, monkeypatch, old, new, sentence):
    cli("run", "toy", "--out", "out")
    with monkeypatch.context() as patch:
        damaging(patch, ".toml", old, new)
        code, out, err = cli("export", "out/result.json", "--to", "toml", "-o", "mine.toml")
    assert (code, out) == (2, "")
    assert err.startswith(f"tuner: {sentence}")
    assert len(err.splitlines()) == 1


# Claims.


def test_a_claim_alone(cli, here, toy):
    code, out, err = cli("run", "toy", "--claim", "toy.lowest", "--out", "out")
    assert (code, err) == (0, "")
    result = read_result(here / "out")
    assert [row.quantity for row in result.comparisons] == ["toy.lowest"]
    assert "toy.lowest" in out
    for other in ("toy.b_over_a", "toy.known", "side"):
        assert other not in out
    # Only what it needs is solved; nothing is exported, checked or drawn.
    assert {s.problem for s in result.solutions} == {"toy"}
    assert (result.exports, result.single_precision, result.tuned) == ([], [], [])
    report = {"report.json", "report.html"}
    assert set(snapshot(here / "out")) == report | {"result.json", "study.toml", "environment.json"}
    code, out, err = cli("export", "out", "--to", "c")
    assert (code, out) == (2, "")
    assert err == (
        "tuner: the run of toy tuned no filter that is exported; run it without --claim\n"
    )
    assert cli("compare", "out", "--tol", "25%")[0] == 0


def test_a_claim_that_needs_no_solution(cli, here, toy):
    code, out, err = cli("run", "toy", "--claim", "toy.known")
    assert (code, err) == (0, "")
    assert "Solutions" not in out
    assert "toy.known" in out
    assert read_result(here / "runs" / "toy-001").solutions == []


def test_several_claims_by_name_and_pattern(cli, here, toy):
    words = ("--claim", "toy.k*", "--claim", "toy.?owest", "--json")
    rows = json.loads(cli("run", "toy", *words)[1])["comparisons"]
    assert [row["quantity"] for row in rows] == ["toy.lowest", "toy.known"]


def test_claims_do_not_converge_and_that_is_no_failure(cli, here, toy):
    """Nothing is exported that could be trusted or not; the row says what was found."""
    words = ("--set", "objective=slope", "--claim", "toy.lowest", "--json")
    code, out, _ = cli("run", "toy", *words)
    assert code == 0
    assert json.loads(out)["solutions"][0]["status"] == "at bound"


def test_an_unknown_claim_is_told_the_near_ones(cli, here, toy):
    code, out, err = cli("run", "toy", "--claim", "toy.lowets")
    assert (code, out) == (2, "")
    assert err == (
        "tuner: unknown claim 'toy.lowets'; did you mean toy.lowest or toy.known? "
        "There are: toy.b_over_a, toy.known, toy.lowest\n"
    )
    assert snapshot(here) == {}


def test_a_run_on_a_log_has_no_claims(cli, here, toy):
    write_csv(here / "rest.csv", np.arange(50) / 10, np.sin(np.arange(50.0)))
    words = ("run", "toy", "--log", "rest.csv", "--map", "x=g", "--out", "out")
    code, _, err = cli(*words, "--claim", "toy.lowest")
    assert code == 2
    assert err.splitlines()[-1] == "tuner: unknown claim 'toy.lowest'; there are none"
    assert not (here / "out").exists()
    code, out, _ = cli(*words)
    assert code == 0
    assert "Comparison" not in out
    assert read_result(here / "out").comparisons == []


def test_the_recipe_keeps_the_claims(cli, here, toy):
    cli("run", "toy", "--claim", "toy.lowest", "--claim", "toy.known", "--out", "out")
    assert read_recipe(here / "out/study.toml").claims == ["toy.lowest", "toy.known"]
    assert cli("run", "out/study.toml", "--out", "again")[0] == 0
    one, other = (read_result(here / name) for name in ("out", "again"))
    assert one.comparisons == other.comparisons
    assert (here / "out/study.toml").read_bytes() == (here / "again/study.toml").read_bytes()
    # The command line wins.
    assert cli("run", "out/study.toml", "--claim", "toy.known", "--out", "third")[0] == 0
    assert [row.quantity for row in read_result(here / "third").comparisons] == ["toy.known"]
    # A whole run says nothing of claims.
    cli("run", "toy", "--out", "whole")
    assert b"claims" not in (here / "whole/study.toml").read_bytes()


def test_dry_run_names_the_claims(cli, here, toy):
    lines = cli("run", "toy", "--dry-run")[1].splitlines()
    assert lines[-1] == "would try toy.b_over_a, toy.lowest, toy.known"
    lines = cli("run", "toy", "--dry-run", "--claim", "toy.known")[1].splitlines()
    assert lines[-1] == "would try toy.known"
    assert not any("lowest" in line for line in lines)
    assert snapshot(here) == {}


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

    offer(replace(toy_study(), channels=None))
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
    assert cli("run", "toy", "--out", "out")[0] == 2
    assert not list(here.iterdir())  # nothing was found, so nothing is left


def test_a_run_that_fails_leaves_what_others_wrote(cli, here, offer):
    def failing(name, **options):
        return Solved(name, lambda problem: 1 / 0)

    offer(toy_study(solver=failing))
    (here / "out").mkdir()
    (here / "out" / "notes.txt").write_text("precious")
    assert cli("run", "toy", "--out", "out", "--force")[0] == 2
    assert [path.name for path in (here / "out").iterdir()] == ["notes.txt"]


def test_who_asks_for_a_traceback_sees_it(cli, toy):
    code, out, err = cli("run", "toy", "--log", "nowhere.csv", "--map", "x=g", "--traceback")
    assert (code, out) == (2, "")
    assert err.startswith("Traceback (most recent call last):")
    assert err.splitlines()[-1].startswith("tuner: nowhere.csv: there is no such file")


def test_samplers_of_one_run_share_its_database(cli, here, offer):
    def few(name, *, seed, starts, storage):
        return Sampler(name, seed=seed, storage=storage, trials=2)

    offer(toy_study(solver=few))
    words = ("--set", 'solvers=["cma-es", "tpe"]', "--out", "out")
    code, _, err = cli("run", "toy", *words)
    assert (code, err) == (1, "")
    assert (here / "out" / "trials.sqlite3").is_file()
    assert [s.evaluations for s in read_result(here / "out").solutions] == [3] * 4


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
        (["run"], "missing argument"),
        (["runn"], "run"),
        (["export", "out"], "--to"),
        (["compare"], "missing argument"),
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
    assert ran.stderr == "tuner: setting R: must be above 0, got -1\n"
    assert snapshot(here) == {}


def test_process_survives_a_closed_pipe(cache, here):
    code = "import sys; from tuner.cli import main; sys.argv[0] = 'tuner'; main()"
    shell = f"{sys.executable!r} -c {code!r} list formats --json | true"
    ran = subprocess.run(
        ["sh", "-c", shell], capture_output=True, text=True, check=False, env={**os.environ}
    )
    assert "Traceback" not in ran.stderr
