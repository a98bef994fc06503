"""C on the command line: what a run writes, what exports give, what is said where there is none."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.tuner.code.compiled import compile_in, needed, ran
from tuner.cli import invoke
from tuner.export import load
from tuner.run.result import read_result

PROJECT = Path(__file__).resolve().parents[3]
CASE = PROJECT.parent / "shared" / "cases" / "mcu-gain"
DESIGN = """
study = "design"
[settings]
states = ["height", "climb"]
A = [[0, 1], [0, 0]]
G = [[0], [1]]
C = [[1, 0]]
Q = [[0.04]]
R = [[0.5]]
error = "climb"
"""
MAIN = r"""
#include <stdio.h>
#include "observer.h"
int main(void)
{
    minimum_variance_state state;
    minimum_variance_input in;
    minimum_variance_output out;
    const float K[2][1] = MINIMUM_VARIANCE_K_F;
    minimum_variance_init(&state);
    while (scanf("%f", &in.z[0]) == 1) {
        minimum_variance_step(&state, &in, &out);
    }
    printf("%.9g %.9g %.9g %.9g\n", (double)K[0][0], (double)K[1][0],
        (double)out.x[MINIMUM_VARIANCE_STATE_HEIGHT], (double)out.x[MINIMUM_VARIANCE_STATE_CLIMB]);
    return 0;
}
"""


@pytest.fixture(scope="module")
def designed(tmp_path_factory, cache):
    """A run of a designed observer."""
    folder = tmp_path_factory.mktemp("designed")
    (folder / "design.toml").write_text(DESIGN + "sample_time = 0.04\n")
    command = ["run", str(folder / "design.toml"), "--out", str(folder / "run"), "--jobs", "1"]
    assert invoke(command) == 0
    return folder / "run"


@pytest.fixture
def observer(designed, here):
    """An empty folder with the run in it."""
    shutil.copytree(designed, here / "run")
    return here


def end_of(folder, heights):
    """The gain, and the last height and climb of the program on a controller."""
    needed("gcc")
    (folder / "main.c").write_text(MAIN)
    command = ["gcc", "-std=c99", "main.c", "observer.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    given = "\n".join(map(str, heights))
    told = subprocess.run(["./main"], cwd=folder, input=given, stdout=-1, text=True, check=True)
    names = ("K1", "K2", "last_height", "last_climb")
    return dict(zip(names, map(float, told.stdout.split()), strict=True))


def test_a_designed_observer_runs_on_a_controller(cli, observer):
    code, _, err = cli("export", "run", "--to", "c", "--precision", "float", "-o", "observer.h")
    assert code == 0, err
    assert err == (
        "wrote observer.h: 15 quantities, read back equal; observer.c and observer_selftest.c\n"
    )
    header = (observer / "observer.h").read_text()
    assert "float x[2]; /* estimate: height, climb */" in header
    assert re.search(r"an error of that start falls to 2 % in about \d+ samples", header)
    found = end_of(observer, 250 + 2.0 * np.arange(400) * 0.04)
    assert found["last_height"] == pytest.approx(250 + 2 * 399 * 0.04, abs=1e-3)
    assert found["last_climb"] == pytest.approx(2.0, abs=1e-3)
    told = {code.precision: code for code in read_result(observer / "run").code}
    assert set(told) == {"double", "float"}
    assert told["float"].operations < 30
    assert told["double"].file == "exports/minimum_variance.h"


@pytest.mark.skipif(not CASE.is_dir(), reason=f"there is no {CASE} with the problem")
def test_the_published_problem_is_answered(cli, observer):
    code, _, err = cli("export", "run", "--to", "c", "--precision", "float", "-o", "observer.h")
    assert code == 0, err
    answer = end_of(observer, np.loadtxt(CASE / "input.csv"))
    (observer / "answer.json").write_text(json.dumps(answer))
    said = ran(observer, sys.executable, str(CASE / "check.py"), "answer.json")
    assert said.returncode == 0, said.stdout


def test_variants_and_other_names(cli, observer):
    needed("gcc")
    for words in ((), ("--tunable",), ("--precision", "float", "--tunable")):
        code, _, err = cli("export", "run", "--to", "c", *words, "-o", "here/../own.h", "--force")
        assert code == 2 if not (observer / "here").is_dir() else 0, err
        code, _, err = cli("export", "run", "--to", "c", *words, "-o", "own.h", "--force")
        assert code == 0, err
        assert ("own_params" not in (observer / "own.h").read_text()) or words
        options = ("-DSELFTEST_MAIN", "own.c", "own_selftest.c", "-o", "own", "-lm")
        compile_in(observer, "gcc", *options)
        assert ran(observer, "./own").returncode == 0
    code, out, _ = cli("export", "run", "--to", "c", "-o", "-")
    assert code == 0
    assert load(out.encode(), "c") == load((observer / "own.h").read_bytes(), "c")
    (observer / "whole.c").write_text(out)
    compile_in(observer, "gcc", "-c", "whole.c")


def test_none_of_three_files_is_replaced(cli, observer):
    Path("gain.c").write_text("precious")
    code, _, err = cli("export", "run", "--to", "c", "-o", "gain.h")
    assert code == 2
    assert "gain.c exists" in err
    assert not Path("gain.h").exists()
    assert not Path("gain_selftest.c").exists()
    assert Path("gain.c").read_text() == "precious"


def test_at_another_rate(cli, observer):
    needed("gcc")
    words = ("--rate", 50, "--precision", "float", "-o", "fast.h")
    code, _, err = cli("export", "run", "--to", "c", *words)
    assert code == 0, err
    assert load(Path("fast.h").read_bytes(), "c").dt == 0.02
    compile_in(observer, "gcc", "-DSELFTEST_MAIN", "fast.c", "fast_selftest.c", "-o", "a", "-lm")
    assert ran(observer, "./a").returncode == 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--to", "json", "--tunable"), "--precision and --tunable need --to c"),
        (("--to", "c", "--precision", "half"), "--precision is 'half'; give double or float"),
        (("--to", "c", "-o", "gyro.c"), "gyro.c is the name of the source; name the header"),
    ],
)
def test_what_is_asked_for_in_vain(cli, observer, words, told):
    code, _, err = cli("export", "run", *words)
    assert code == 2
    assert told in err
    assert err.count("\n") == 1


def test_code_of_other_numbers_is_refused(cli, observer):
    file = observer / "run" / "result.json"
    result = json.loads(file.read_text())
    result["tuned"][0]["quantities"][2]["value"][0][0] += 1.0
    file.write_text(json.dumps(result))
    code, _, err = cli("export", "run", "--to", "c", "-o", "other.h")
    assert code == 2
    assert "was not written by this run; run it again" in err
    assert not Path("other.h").exists()


def test_a_continuous_design_has_numbers_alone(cli, here):
    (here / "design.toml").write_text(DESIGN)
    code, _, err = cli("run", "design.toml", "--out", "run", "--jobs", 1)
    assert code == 0, err
    told = "minimum_variance is a design without a filter that runs on samples"
    assert [one.refused.startswith(told) for one in read_result(here / "run").code] == [True] * 2
    code, _, err = cli("export", "run", "--to", "c", "-o", "numbers.h")
    assert code == 0
    assert err.startswith(f"numbers only: {told}")
    assert load(Path("numbers.h").read_bytes(), "c").name == "minimum_variance"
    assert cli("export", "run", "--to", "c", "--tunable", "-o", "more.h")[0] == 2
    assert not Path("more.h").exists()
