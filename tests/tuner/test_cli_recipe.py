"""study.toml: what is wrong with it in one line, what wins over it, and which log it means."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.tuner.helpers import snapshot, write_csv
from tuner.run.recipe import LogEntries, Recipe, read_recipe


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "study: Field required"),
        ("study = 3", "study: must be a valid string"),
        ("study = 'toy'\nsettings = 3", "settings: must be a valid dictionary"),
        ("study = 'toy'\nseed = 'x'", "seed: must be a valid integer"),
        ("study = 'toy'\nseed = 1.5", "seed: must be a valid integer"),
        ("study = 'toy'\nseed = -1", "seed: must be at least 0"),
        ("study = 'toy'\nseed = 99999999999", "seed: must be at most"),
        ("study = 'toy'\nsed = 1", "unknown entry 'sed'; did you mean seed?"),
        ("study = 'toy'\nlog = 'x'", "log: must be"),
        (
            "study = 'toy'\n[log]\nfiles = ['x']\nsha256 = ['']\nmap = []\nrate = 1.0",
            "unknown entry 'rate'; did you mean rate_hz",
        ),
        (
            "study = 'toy'\n[log]\nfiles = ['x', 'y']\nsha256 = ['']\nmap = []",
            "log: 2 files and 1 sha256; each file has its own",
        ),
        (
            "study = 'toy'\n[log]\nfiles = []\nsha256 = []\nmap = []",
            "the log names no file; name at least one",
        ),
        (
            "study = 'toy'\n[log]\nfiles = ['x']\nsha256 = ['']\nmap = 'x=g'",
            "log.map: must be a valid list",
        ),
        (
            "study = 'toy'\n[log]\nfiles = ['x']\nsha256 = ['']\nmap = []\nrate_hz = '1'",
            "log.rate_hz: must be a valid number",
        ),
        (
            "study = 'toy'\nsed = 1\nseed = 1.5\n[log]\nfile = ['x']",
            "seed: must be a valid integer",
        ),
        ("][", "Invalid"),
        ("study = 'toy'\nstudy = 'toy'", "Cannot overwrite a value"),
        (b"\xff\xfe", "it is no text in UTF-8; save it as such"),
    ],
)
def test_faults_are_told_in_one_line(cli, here, toy, text, sentence):
    file = here / "my.toml"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    before = snapshot(here)
    code, out, err = cli("run", "my.toml")
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith(f"tuner: my.toml is not a study.toml: {sentence}"), err
    assert snapshot(here) == before


def test_a_file_that_is_not_there_or_a_folder(cli, here, toy):
    (here / "folder.toml").mkdir()
    assert cli("run", "no.toml")[2] == (
        "tuner: no.toml does not exist; name a study or a study.toml\n"
    )
    assert cli("run", "folder.toml") == (
        2,
        "",
        "tuner: folder.toml is not a study.toml: folder.toml is a folder, not a file; write its "
        "data to a file, and name that\n",
    )


def test_settings_of_the_file_are_checked_like_those_of_the_command_line(cli, here, toy):
    (here / "my.toml").write_text("study = 'toy'\n[settings]\nstart = 3\n")
    code, _, err = cli("run", "my.toml")
    assert code == 2
    assert err.startswith("tuner: my.toml: unknown setting 'start'; did you mean starts?")
    assert not (here / "runs").exists()


def test_the_command_line_wins(cli, here, toy):
    (here / "my.toml").write_text("study = 'toy'\nseed = 3\n[settings]\nstarts = 4\n")

    def ran(*words):
        code, out, _ = cli("run", "my.toml", "--json", *words)
        assert code == 0
        return json.loads(out)

    result = ran()
    assert (result["seed"], result["settings"]["starts"]) == (3, 4)
    result = ran("--seed", 0, "--set", "starts=2")
    assert (result["seed"], result["settings"]["starts"]) == (0, 2)
    # What a run writes down is what it did, the rest in its default.
    resolved = read_recipe(here / "runs" / "toy-002" / "study.toml")
    assert resolved == Recipe(
        study="toy",
        seed=0,
        settings={"solvers": ["nelder-mead", "l-bfgs-b"], "starts": 2, "objective": "bowl"},
        log=None,
    )


def logged(here, name="rest.csv", function=np.sin):
    return write_csv(here / name, np.arange(50) / 10, function(np.arange(50.0)))


def test_a_log_is_found_beside_the_file_or_here(cli, here, toy):
    log = logged(here)
    words = ("--map", "x=g*2:m", "--rate", 10, "--time", "t")
    assert cli("run", "toy", "--log", log, *words, "--out", "out")[0] == 0
    recipe = read_recipe(here / "out" / "study.toml")
    assert (recipe.log.files, recipe.log.map) == (["rest.csv"], ["x=g*2:m"])
    assert (recipe.log.rate_hz, recipe.log.time) == (10.0, "t")
    assert cli("run", "out/study.toml", "--out", "again")[0] == 0
    timed = ("result.json", "report.html")
    first, again = (
        {n: d for n, d in snapshot(here / name).items() if n not in timed}
        for name in ("out", "again")
    )
    assert first == again
    log.rename(here / "out" / "rest.csv")
    assert cli("run", "out/study.toml", "--out", "third")[0] == 0
    (here / "out" / "rest.csv").rename(here / "elsewhere.csv")
    code, _, err = cli("run", "out/study.toml", "--out", "fourth")
    assert code == 2
    assert err == (
        "tuner: the log rest.csv of out/study.toml is not here; say where with --log FILE\n"
    )
    assert cli("run", "out/study.toml", "--out", "fourth", "--log", "elsewhere.csv")[0] == 0


def test_another_log_of_the_same_name_is_refused_unless_it_is_named(cli, here, toy):
    log = logged(here)
    assert cli("run", "toy", "--log", log, "--map", "x=g", "--out", "out")[0] == 0
    logged(here, function=np.cos)
    code, _, err = cli("run", "out/study.toml", "--out", "again")
    assert code == 2
    assert err.startswith("tuner: rest.csv is not the log of study.toml: its SHA-256 differs")
    assert cli("run", "out/study.toml", "--out", "again", "--log", "rest.csv")[0] == 0


@pytest.mark.parametrize(
    "words", [("--map", "x=g"), ("--rate", 10), ("--rate", 0), ("--time", "t")]
)
def test_how_to_read_a_log_that_is_not_named(cli, here, toy, words):
    code, _, err = cli("run", "toy", *words)
    assert code == 2
    assert err == f"tuner: {words[0]} says how to read a log, but there is no --log FILE\n"
    assert snapshot(here) == {}


def test_text_of_a_recipe_can_be_read_back(here):
    recipe = Recipe(
        study="toy",
        seed=7,
        settings={"a": 1.5, "b": [[1.0, 2.0], [3.0, 4.0]], "c": "text\n'\"\\", "d": True},
        log=LogEntries(
            files=["x y.csv", "z.csv"],
            sha256=["0f", "1e"],
            map=["a=b"],
            truth=["c=d,e:deg"],
            rate_hz=100.0,
            by="track",
        ),
    )
    Path("study.toml").write_bytes(recipe.to_toml())
    assert read_recipe(Path("study.toml")) == recipe
    assert re.search(rb"^seed = 7$", recipe.to_toml(), re.MULTILINE)
