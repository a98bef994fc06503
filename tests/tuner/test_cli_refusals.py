"""Bad input on the command line: exit code 2, one line that helps, and nothing written."""

import pickle
from pathlib import Path

import numpy as np
import pytest

DRAW = np.random.default_rng(6).standard_normal(400).round(4)


def column(values):
    return "t,gx\n" + "\n".join(f"{0.01 * i:.2f},{v}" for i, v in enumerate(values)) + "\n"


def swapped(values, row, text):
    return [text if i == row else v for i, v in enumerate(values)]


def lines(rows):
    return "t,gx\n" + "\n".join(rows) + "\n"


def clocked(times):
    return lines([f"{t:.4f},{v}" for t, v in zip(times, DRAW, strict=True)])


TIMES = 0.01 * np.arange(400)

LOGS = {
    "empty": ("", "empty"),
    "header only": ("t,gx\n", "not one row"),
    "text in a number column": (column(swapped(DRAW, 5, "oops")), "oops"),
    "NaN run": (column([*DRAW[:50], *["nan"] * 9, *DRAW[59:]]), "misses 9 samples"),
    "Inf run": (column([*DRAW[:50], *["inf"] * 3, *DRAW[53:]]), "misses 3 samples"),
    "constant channel": (column([1.5] * 400), "constant"),
    "backwards time": (clocked(np.where(np.arange(400) == 200, 0.5, TIMES)), "t"),
    "too few samples for Welch": (column(DRAW[:30]), "too few"),
}


@pytest.mark.parametrize("case", LOGS)
def test_bad_logs(cli, here, case):
    text, word = LOGS[case]
    Path("rest.csv").write_text(text)
    refused(cli("run", "kownacki2010", "--log", "rest.csv", "--map", "omega=gx"), word)
    assert [path.name for path in here.iterdir()] == ["rest.csv"]


@pytest.mark.parametrize(
    ("words", "word"),
    [
        (["--map", "omega=gz"], "gx"),
        (["--map", "omga=gx"], "omega"),
        (["--map", "omega=gx", "--rate", "-1"], "-1"),
        ([], "--map"),
    ],
)
def test_bad_ways_to_read_a_good_log(cli, here, words, word):
    Path("rest.csv").write_text(column(DRAW))
    refused(cli("run", "kownacki2010", "--log", "rest.csv", *words), word)
    assert [path.name for path in here.iterdir()] == ["rest.csv"]


def test_what_is_read_with_a_note(cli, here):
    times = np.where(np.arange(400) == 200, TIMES[199], TIMES)
    np.savez("rest.npz", gx=DRAW.astype(np.float32), t=times)
    words = ["--log", "rest.npz", "--map", "omega=gx", "--dry-run"]
    code, _, err = cli("run", "kownacki2010", *words)
    assert code == 0
    assert "omega: float32, widened" in err
    assert "time 't': 1 repeated time spread over" in err


class Bomb:
    def __reduce__(self):
        return (Path("touched").touch, ())


def test_pickle_in_an_npz_is_refused_and_not_run(cli, here):
    np.savez("rest.npz", gx=np.array([Bomb()], dtype=object), allow_pickle=True)
    words = ["--log", "rest.npz", "--map", "omega=gx", "--rate", "100"]
    refused(cli("run", "kownacki2010", *words), "pickle")
    assert not Path("touched").exists()
    assert pickle.HIGHEST_PROTOCOL >= 2  # the file above was written with one


@pytest.mark.parametrize(
    ("setting", "word"),
    [
        ("R=-1", "above 0"),
        ("R=0", "above 0"),
        ("Q=0", "above 0"),
        ("Q=-2e-9", "above 0"),
        ("P0=[[0, 0], [0, 0]]", "positive diagonal"),
        ("P0=[[-1, 0], [0, 1]]", "positive"),
        ("P0=[[1, 2], [2, 1]]", "eigenvalue -1"),
        ("P0=[[1, 2], [3, 1]]", "symmetric"),
        ("P0=[1, 1]", "P0"),
        ("R=true", "a truth value does not fit, got True"),
        ("P0=[[true, false], [false, true]]", "a truth value does not fit"),
        ("solvers=nelder-meat", "nelder-mead"),
        ("stp=0.1", "step"),
        ("reading=R5", "R6"),
        ("step", "KEY=VALUE"),
        ("seconds=0.001", "too few"),
    ],
)
def test_bad_settings(cli, here, setting, word):
    refused(cli("run", "kownacki2010", "--set", setting), word)
    assert not list(here.iterdir())


def test_unknown_study_names_the_near_one(cli, here):
    refused(cli("run", "kownacki2011"), "kownacki2010")
    assert not list(here.iterdir())


@pytest.mark.parametrize("words", [["--log", "x.csv"], ["--bogus"], ["--jobs", "0"], ["--resume"]])
def test_bad_usage(cli, here, words):
    refused(cli("run", "kownacki2010", *words), "")
    assert not list(here.iterdir())


def test_existing_output_is_left_alone(cli, here):
    Path("run").mkdir()
    Path("run/result.json").write_text("precious")
    refused(cli("run", "kownacki2010", "--out", "run"), "--force")
    assert Path("run/result.json").read_text() == "precious"


def test_output_that_cannot_be_written(cli, here):
    Path("file").write_text("precious")
    refused(cli("run", "kownacki2010", "--out", "file"), "file")
    refused(cli("run", "kownacki2010", "--out", "file/run", *QUICK), "file/run")
    assert Path("file").read_text() == "precious"


QUICK = ("--set", "seconds=0.01", "--set", "starts=1", "--set", "grid=2", "--set", "cutoff_hz=500")


def refused(outcome, word):
    """Exit code 2, nothing on stdout, and a last line that says what is wrong; no traceback."""
    code, out, err = outcome
    assert code == 2, err
    assert out == ""
    told = [line for line in err.splitlines() if line.startswith("tuner: ")]
    assert told == err.splitlines()[-1:], err
    assert word in told[0]
    assert "Traceback" not in err
