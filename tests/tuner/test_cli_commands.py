"""The command line on a short run: results on stdout, files that can be run, read and exported."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tuner import export
from tuner.cli import invoke

# 0.02 s at 10 kHz: everything that a full run does, in seconds.
SHORT = ["seconds=0.02", "cutoff_hz=400", "starts=1", "solvers=l-bfgs-b", "grid=2"]
SETTINGS = [word for setting in SHORT for word in ("--set", setting)]


@pytest.fixture(scope="module")
def finished(tmp_path_factory, cache):
    folder = tmp_path_factory.mktemp("finished") / "run"
    assert invoke(["run", "kownacki2010", "--out", str(folder), *SETTINGS]) == 0
    return folder


@pytest.fixture
def run(finished, here):
    shutil.copytree(finished, here / "run")
    return Path("run")


def test_json_is_one_object_and_the_run_again_gives_the_same(cli, run):
    code, out, err = cli("run", "run/study.toml", "--out", "again", "--json")
    assert (code, err) == (0, "kownacki2010 takes about a minute on two processors\n")
    result, before = json.loads(out), json.loads(Path("run/result.json").read_text())
    assert next(iter(result)) == "schema"
    assert result == json.loads(Path("again/result.json").read_text())
    for new, old in zip(result["solutions"], before["solutions"], strict=True):
        assert new | {"seconds": 0} == old | {"seconds": 0}
    for key in ("log", "comparisons", "tuned", "artifacts", "settings"):
        assert result[key] == before[key], key


def test_required_rows_are_there_for_both_sensors(run):
    required = """q_over_r k1 bandwidth_hz R Q cost_at_paper_over_optimum q_over_r_literal table1_R
    table1_Q nelder_mead_linear_evaluations"""
    rows = json.loads((run / "result.json").read_text())["comparisons"]
    found = {row["quantity"] for row in rows}
    assert {f"{sensor}.{name}" for sensor in ("gyro", "acc") for name in required.split()} <= found
    assert len(found) == len(rows)


def test_people_get_tables(cli, run):
    code, out, _ = cli("run", "run/study.toml", "--out", "again")
    assert code == 0
    assert "Solutions" in out
    assert "not identifiable" in out
    assert "14 exports, each read back, compared and scored again" in out


def test_no_file_knows_where_it_was_made(run, finished):
    for file in run.rglob("*"):
        assert file.is_dir() or str(finished.parent).encode() not in file.read_bytes(), file


def test_runs_are_numbered_and_never_overwritten(cli, here, toy):
    for _ in range(2):
        assert cli("run", "toy")[0] == 0
    assert sorted(p.name for p in Path("runs").iterdir()) == ["toy-001", "toy-002"]


def test_dry_run_writes_nothing(cli, here):
    code, out, _ = cli("run", "kownacki2010", "--dry-run")
    assert code == 0
    assert "would solve gyro over ln Q by l-bfgs-b" in out
    assert not list(here.iterdir())


def test_compare_reports_rows_outside_their_tolerance(cli, run):
    """So short a record cannot agree with Table 2."""
    assert cli("compare", "run")[0] == 1
    assert cli("compare", "run", "--tol", "1e99")[0] == 0


def test_compare_in_four_forms(cli, run):
    names = [r["quantity"] for r in json.loads(Path("run/result.json").read_text())["comparisons"]]
    (table,) = json.loads(cli("compare", "run", "--json")[1])["runs"]
    assert [row["quantity"] for row in table["rows"]] == names
    rows = list(csv.reader(cli("compare", "run", "run", "--csv")[1].splitlines()))
    assert rows[0] == ["quantity", "where", "unit", "paper", "run", "verdict", "run", "verdict"]
    assert [row[0] for row in rows[1:]] == names
    marked = cli("compare", "run", "--md")[1].splitlines()
    assert len(marked) == len(names) + 2
    assert marked[1].startswith("| --- |")
    assert all(name in cli("compare", "run")[1] for name in names)


@pytest.mark.parametrize("tol", ["5", "5%", "0.05"])
def test_tolerances_that_are_some(cli, run, tol):
    assert cli("compare", "run", "--tol", tol)[0] in (0, 1)


@pytest.mark.parametrize("tol", ["five", "-1%", "nan", ""])
def test_tolerances_that_are_none(cli, run, tol):
    code, _, err = cli("compare", "run", "--tol", tol)
    assert code == 2
    assert "5% or 0.05" in err


@pytest.mark.parametrize("name", export.FORMATS)
def test_export_is_read_back(cli, run, name):
    code, out, err = cli("export", "run", "--to", name, "--problem", "gyro")
    assert (code, out) == (0, "")
    suffix = export.suffix(name)
    more = "; gyro.c and gyro_selftest.c" if name == "c" else ""
    assert err == f"wrote gyro{suffix}: 6 quantities, read back equal{more}\n"
    written = Path(f"gyro{suffix}").read_bytes()
    assert written == (run / "exports" / f"gyro{suffix}").read_bytes()


def test_export_to_stdout_is_the_file_alone(cli, run):
    _, out, err = cli("export", "run", "--to", "json", "--problem", "acc", "-o", "-")
    assert export.load(out.encode(), "json").name == "acc"
    assert err == ""


def test_export_does_not_overwrite(cli, run):
    Path("gyro.h").write_text("precious")
    code, _, err = cli("export", "run", "--to", "c", "--problem", "gyro")
    assert code == 2
    assert "--force" in err
    assert Path("gyro.h").read_text() == "precious"
    assert cli("export", "run", "--to", "c", "--problem", "gyro", "--force")[0] == 0
    assert "GYRO_R" in Path("gyro.h").read_text()


def test_what_did_not_converge_needs_force(cli, run):
    file = Path("run/result.json")
    result = json.loads(file.read_text())
    result["tuned"][0]["provenance"]["status"] = "stalled"
    file.write_text(json.dumps(result))
    code, _, err = cli("export", "run", "--to", "json", "--problem", "gyro")
    assert code == 2
    assert "stalled" in err
    assert not Path("gyro.json").exists()
    assert cli("export", "run", "--to", "json", "--problem", "gyro", "--force")[0] == 0


@pytest.mark.parametrize(
    ("words", "word"),
    [
        (["export", "run", "--to", "c"], "--problem gyro|acc"),
        (["export", "run", "--to", "c", "--problem", "gyr"], "gyro"),
        (["export", "run", "--to", "h", "--problem", "gyro"], "format"),
        (["export", "nowhere", "--to", "c"], "result.json"),
        (["compare", "nowhere"], "result.json"),
        (["compare", "run/study.toml"], "study.toml"),
        (["list", "studdies"], "studies"),
        (["run", "nowhere/study.toml"], "does not exist"),
        (["run", "run/result.json"], "unknown study"),
    ],
)
def test_what_is_not_there_is_said(cli, run, words, word):
    code, _, err = cli(*words)
    assert code == 2
    assert word in err
    assert len(err.splitlines()) == 1


def test_export_of_a_run_of_a_log_needs_no_log(cli, here):
    draw = np.random.default_rng(2)
    np.savez("rest.npz", g=draw.standard_normal(400), fs=np.array(100.0))
    words = ["--log", "rest.npz", "--map", "omega=g", *SETTINGS, "--set", "cutoff_hz=4"]
    assert cli("run", "kownacki2010", *words, "--out", "run")[0] == 0
    Path("rest.npz").unlink()
    assert "read back equal" in cli("export", "run", "--to", "toml")[2]
    assert Path("gyro.toml").read_bytes() == Path("run/exports/gyro.toml").read_bytes()


@pytest.mark.parametrize("what", ["studies", "filters", "objectives", "solvers", "formats"])
def test_lists_in_words_and_as_json(cli, what):
    code, out, _ = cli("list", what)
    assert code == 0
    found = json.loads(cli("list", what, "--json")[1])
    assert found["schema"] == "tuner.list/1"
    assert found[what]
    assert all(name in out for name in found[what])


def test_doctor_finds_this_installation_sound(cli):
    code, out, err = cli("doctor", "--json")
    report = json.loads(out)
    assert (code, err, report["problems"]) == (0, "", [])
    assert report["float64"] is True
    assert report["loop_option"] in {"set", "given"}
    assert "all well" in cli("doctor")[1]
