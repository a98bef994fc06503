"""What a finished run shows again; settings; how wide tables are; progress without a terminal."""

import json
import os
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from tests.tuner.report import made
from tuner.cli import progress_display
from tuner.cli.tables import console, show_grid, show_result
from tuner.report.write import KEPT


@pytest.fixture
def run(here):
    folder = here / "out"
    folder.mkdir()
    (folder / "result.json").write_text(made.result().to_json())
    (folder / KEPT).write_bytes(made.kept().to_json())
    return folder


def test_the_report_again(cli, run):
    assert cli("report", "out") == (0, "out/report.html\n", "")
    page = (run / "report.html").read_text()
    assert "Use it" in page
    assert cli("report", "out") == (0, "out/report.html\n", "")  # a run's own may be replaced
    code, out, err = cli("report", "out/result.json", "-o", "-")
    assert (code, out, err) == (0, page, "")


def test_other_forms(cli, run, here):
    assert cli("report", "out", "--to", "md") == (0, "out/report.md\n", "")
    code, out, err = cli("report", "out", "--to", "md")
    assert (code, out) == (2, "")
    assert "report.md" in err
    assert cli("report", "out", "--to", "md", "--force")[0] == 0
    assert cli("report", "out", "-o", "mine.md") == (0, "mine.md\n", "")
    assert (here / "mine.md").read_bytes() == (run / "report.md").read_bytes()
    code, out, err = cli("report", "out", "--to", "doc")
    assert (code, out) == (2, "")
    assert err == "tuner: unknown form 'doc'; there are: html, md, pdf\n"


def test_a_pdf_takes_a_browser(cli, run, monkeypatch):
    monkeypatch.setattr("tuner.report.pdf.shutil.which", lambda _: None)
    monkeypatch.setattr("tuner.report.pdf.PLACES", ())
    code, out, err = cli("report", "out", "--to", "pdf")
    assert (code, out) == (2, "")
    assert err.startswith("tuner: no browser was found to print the PDF (Chromium")


@pytest.mark.parametrize("command", ["show", "report"])
def test_a_folder_of_no_run(cli, here, command):
    code, out, err = cli(command, "nowhere")
    assert (code, out) == (2, "")
    assert err == "tuner: nowhere holds no result.json; give the folder of a finished run\n"


def test_a_run_is_shown_again(cli, run):
    code, out, err = cli("show", "out")
    assert (code, err) == (0, "")
    assert out.splitlines()[-5:] == made.fit().lines
    assert "the report is out/report.html" in out
    code, out, err = cli("show", "out", "--json")
    assert out == (run / "result.json").read_text()


def test_of_a_long_result_what_is_met_is_counted(here, capsys):
    rows = made.study().comparisons * 12
    show_result(made.study().model_copy(update={"comparisons": rows}), here, whole=False)
    out = capsys.readouterr().out
    assert "not shown: 0 searches, 24 rows met" in out
    assert "differs" in out
    assert "claim holds" not in out


def test_the_version(cli):
    code, out, err = cli("--version")
    assert (code, err) == (0, "")
    assert out.startswith("filter-tuner ")


def test_settings_of_a_study(cli):
    code, out, err = cli("list", "settings", "suh2004", "--json")
    assert (code, err) == (0, "")
    told = json.loads(out)["settings"]["suh2004"]
    assert all(each["meaning"] for each in told.values())
    code, table, err = cli("list", "settings", "suh2004")
    assert all(name in table for name in told)
    code, out, err = cli("run", "suh2004", "--help")
    assert (code, err) == (0, "")
    assert out.endswith(table)
    assert "\nneeds no data: it simulates them\ntakes about " in table
    assert "--resume" in out


def test_settings_of_nothing(cli):
    code, out, err = cli("list", "settings")
    assert (code, out) == (2, "")
    assert err.startswith("tuner: settings belong to a study; name one: broad, chauhan2009, ")


@pytest.mark.parametrize("width", [44, 80, 200])
def test_tables_fit_and_cut_no_number(monkeypatch, capsys, width):
    monkeypatch.setenv("COLUMNS", str(width))
    assert console().width == width
    words, number = "a name of several words and letters", "-1.23456e-08"
    show_grid("Title", [["name", "value", "note"], [words, number, words * 3]])
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= width
    assert number in out


@pytest.mark.parametrize("columns", [5, 7])
def test_narrow_tables_break_no_word(monkeypatch, capsys, columns):
    monkeypatch.setenv("COLUMNS", "80")
    names = ["name", "unit", "typical", "meaning", "in data sheet units", "smaller", "larger"]
    cells = ["q", "m^2/s^3", "0.01", "spectral density of a noise: its variance times dt"]
    cells += ["accelerometer_noise_density", "trusts the accelerometer", "follows the barometer"]
    show_grid("Title", [names[:columns], cells[:columns]])
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 80
    assert {word for cell in cells[:columns] for word in cell.split()} <= set(out.split())


def test_lines_end_where_columns_say(monkeypatch, capsys, here):
    monkeypatch.setenv("COLUMNS", "60")
    lines = [
        f"use       {'q = 1, ' * 30}",
        "next      tuner export RUN --to c -o a_long_name.h " * 2,
    ]
    show_result(made.result(fit=made.fit(lines=lines)), here / "out")
    *_, first, second, last = capsys.readouterr().out.splitlines()
    assert len(first) <= 60
    assert second.startswith(" " * 10)
    assert second.strip()
    assert last.startswith(f"next      tuner export {here / 'out'} --to c")


def test_progress_without_a_terminal(monkeypatch, capsys):
    monkeypatch.setenv("TUNER_PROGRESS", "0.01")
    checked = []
    with progress_display.show_progress(lambda: checked.append(True)) as report:
        report("level: l-bfgs-b", 1, 3)
        time.sleep(0.1)
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1] == "0 s: level: l-bfgs-b, 1 of 3"
    assert checked == [True]
    with progress_display.show_planning():
        time.sleep(0.05)
    assert "0 s: reading and planning\n" in capsys.readouterr().err
    monkeypatch.setenv("TUNER_PROGRESS", "0")
    with progress_display.show_planning():
        time.sleep(0.05)
    assert capsys.readouterr().err == ""
    monkeypatch.setenv("TUNER_PROGRESS", "often")
    with pytest.raises(ValueError, match=r"^TUNER_PROGRESS is 'often'; give seconds"):
        progress_display.show_planning().__enter__()


def test_the_dashboard(cli, run, monkeypatch):
    assert cli("dashboard")[2] == (
        "tuner: name a run, tuner dashboard RUN, or give --storage URL\n"
    )
    assert cli("dashboard", "out")[2].startswith(
        "tuner: out holds no trials.sqlite3: only samplers"
    )
    (run / "trials.sqlite3").touch()
    monkeypatch.setattr("tuner.cli.dashboard.find_spec", lambda _: None)
    code, out, err = cli("dashboard", "out")
    assert (code, out) == (2, "")
    assert err.endswith("pip install 'filter-tuner[dashboard]'\n")
    served = []
    there = SimpleNamespace(run_server=lambda url, **how: served.append((url, how)))
    monkeypatch.setitem(sys.modules, "optuna_dashboard", there)
    monkeypatch.setattr("tuner.cli.dashboard.find_spec", lambda _: there)
    assert cli("dashboard", "out", "--port", 9000) == (0, "", "")
    assert cli("dashboard", "--storage", "sqlite:///x.db")[0] == 0
    here = {"host": "localhost"}
    assert served == [
        ("sqlite:///out/trials.sqlite3", {**here, "port": 9000}),
        ("sqlite:///x.db", {**here, "port": 8080}),
    ]


def test_a_shell_completes_commands():
    asked = {"_TUNER_COMPLETE": "complete_bash", "COMP_WORDS": "tuner re", "COMP_CWORD": "1"}
    ran = subprocess.run(
        [sys.executable, "-c", "from tuner.cli import main; main()"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **asked},
    )
    assert (ran.returncode, ran.stdout.split()) == (0, ["report"])
