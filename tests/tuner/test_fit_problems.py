"""Public users' problems, each answered by one command, held against their right answers.

They are no part of this project: without the folder ``cases`` beside it, the tests are skipped.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tuner.run.result import read_result

CASES = Path(__file__).resolve().parents[2].parent / "shared" / "cases"
pytestmark = pytest.mark.skipif(
    not (CASES / "lib" / "verdict.py").exists(), reason=f"there is no {CASES} with the problems"
)


class Answer:
    """What a run found, by name."""

    def __init__(self, folder):
        self.result = read_result(folder)
        self.outputs = np.load(folder / "outputs.npz")
        self.parameters = self.result.solutions[0].parameters
        self.dt = self.result.tuned[0]["dt"]

    def __getitem__(self, name):
        return self.parameters[name].value


def pressure(found):
    """Its intervals are not held against the right ones: they are where the cost changes by 1 %."""
    return {"Q": found.result.solutions[0].derived["Q"], "R": found["R"]}


def current(found):
    return pressure(found)


def vario(found):
    return {
        "sigma_baro": found["R_baro"] ** 0.5,
        "sigma_acc": (found["q_acc"] / found.dt) ** 0.5,
        "climb_end": found.outputs["climb"][-600:].mean(),
        "offset_end": found.outputs["bias"][-600:].mean(),
    }


def gps(found):
    return {"q": found["q"], "s": found["R"] ** 0.5}


def noise(found):
    return {"q": found["q"], "R": found["R"]}


def beta(found):
    return {"beta": found["beta"], "rmse": found.result.fit.tuned}


def nis(found):
    before = found.result.fit.consistency[0].nis
    return {"nis": before, "factor": before, "q": found["q"], "R": found["R"]}


PROBLEMS = {
    "level-pressure": ("pressure.csv", "local-level", "z=pressure_Pa:Pa", pressure),
    "vario": ("vario.csv", "vertical", "acc=acc_up_ms2:m/s^2 baro=baro_m:m", vario),
    "gps-accuracy": (
        "track.csv",
        "constant-velocity",
        "x=latitude:lat y=longitude:lon sigma=accuracy:m",
        gps,
    ),
    "several-tracks": ("tracks.csv", "constant-velocity", "x=x:m", noise),
    "madgwick-beta": ("imu_mocap.npz", "madgwick", "gyr=gyr:rad/s acc=acc:m/s^2", beta),
    "nis-check": ("track1d.csv", "constant-velocity", "x=x:m", nis),
    "tiny-units": ("ampere.csv", "local-level", "z=Current~[A]:A", current),
}
MORE = {
    "level-pressure": ("--time", "millis:ms"),
    "gps-accuracy": ("--time", "time:ms"),
    "several-tracks": ("--by", "track_id"),
    "madgwick-beta": ("--truth", "att=quat"),
    "nis-check": ("--start", "q=4", "--start", "R=25"),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_problem_is_answered_by_one_command(name, cli, here):
    file, filter, maps, answer = PROBLEMS[name]
    words = ["--filter", filter, *MORE.get(name, ())]
    for text in maps.split():
        words += ["--map", text.replace("~", " ")]
    # A second start and the rest of the data judge elsewhere.
    quick = ("--starts", 1, "--no-hold-out", "--jobs", 1)
    code, out, err = cli("fit", CASES / name / file, *words, *quick, "--out", "out")
    assert code == 0, (out, err)
    (here / "answer.json").write_text(json.dumps(answer(Answer(here / "out")), default=float))
    said = subprocess.run(
        [sys.executable, str(CASES / name / "check.py"), "answer.json"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert said.returncode == 0, said.stdout
