"""Public users' problems, each answered by one command, held against their right answers.

They are no part of this project: without the folder ``cases`` beside it, the tests are skipped.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tuner
from tuner.run.result import read_result

PROJECT = Path(__file__).resolve().parents[2]
CASES = PROJECT.parent / "shared" / "cases"
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
    before = found.result.fit.diagnostics[0]
    return {"nis": before.nis, "factor": before.factor, "q": found["q"], "R": found["R"]}


def sonar(found):
    refused = int(found.outputs["rejected"].sum())
    assert f"{refused} of 1198 numbers rejected" in found.result.fit.lines[2]
    return {"sigma": found["R"] ** 0.5, "q": found["q"], "refused": refused}


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
    "outliers-sonar": ("sonar.csv", "constant-velocity", "x=range_m:m", sonar),
    "tiny-units": ("ampere.csv", "local-level", "z=Current~[A]:A", current),
}
MORE = {
    "level-pressure": ("--time", "millis:ms"),
    "gps-accuracy": ("--time", "time:ms"),
    "several-tracks": ("--by", "track_id"),
    "madgwick-beta": ("--truth", "att=quat"),
    "outliers-sonar": ("--set", "gate=4"),
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
    check(name, answer(Answer(here / "out")), here)


def test_values_in_use_are_checked_by_one_command(cli, here):
    log = CASES / "nis-check" / "track1d.csv"
    words = ("--filter", "constant-velocity", "--map", "x=x:m", "--log", log, "--json")
    code, out, err = cli("check", *words, "--set", "q=4", "--set", "R=25")
    assert code == 0, err
    found = json.loads(out)["diagnostics"]
    check("nis-check", {"nis": found["nis"], "factor": found["factor"]}, here)
    assert found["factor_low"] < found["factor"] < found["factor_high"]
    assert [f["test"] for f in found["findings"] if f["verdict"] == "failed"] == ["size"]


def test_wrong_echoes_are_counted(cli, here):
    """Of the sonar's 1200 ranges 51 are wrong."""
    log = CASES / "outliers-sonar" / "sonar.csv"
    words = ("--filter", "constant-velocity", "--map", "x=range_m:m", "--log", log, "--json")
    code, out, err = cli("check", *words, "--set", "q=0.0221", "--set", "R=5.9e-5")
    assert code == 0, err
    found = {f["test"]: f for f in json.loads(out)["diagnostics"]["findings"]}
    assert found["outliers"]["verdict"] == "failed"
    assert found["outliers"]["statistic"] >= 51


def check(name, answer, here):
    (here / "answer.json").write_text(json.dumps(answer, default=float))
    said = subprocess.run(
        [sys.executable, str(CASES / name / "check.py"), "answer.json"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert said.returncode == 0, said.stdout


def test_a_model_of_ones_own_is_tuned_by_one_call(here, monkeypatch):
    """The wheeled robot of docs/fit.md, on the recording of a real one."""
    page = (PROJECT / "docs" / "fit.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n# robot\.py\n(.*?)```", page, re.DOTALL)
    (here / "robot.py").write_text(block)
    monkeypatch.syspath_prepend(str(here))
    from robot import Robot

    files = [CASES / "robot-2d" / name for name in ("odom.csv", "gps.csv")]
    maps = ["speed=field.twist.linear.x:m/s", "turn=field.twist.angular.z:rad/s"]
    record = tuner.read_record(files, [*maps, "gps=field.x,field.y:m"])
    fit = tuner.fit(Robot, record, starts=1, hold_out=False)
    dt = fit.posed.problem.filter.dt
    found = {name: float(p.value) for name, p in fit.solution.parameters.items()}
    answer = {
        "sigma_v": (found["q_speed"] / dt) ** 0.5,
        "sigma_w": (found["q_turn"] / dt) ** 0.5,
        "sigma_gps": found["R"] ** 0.5,
    }
    check("robot-2d", answer, here)


def found_in(folder):
    """What a run found besides its solutions, by name."""
    return {row.name: row for row in read_result(folder).findings}


def test_a_gyroscope_at_rest_for_hours(cli, here):
    log = CASES / "allan-static" / "gyro_rest.csv.gz"
    words = ["--map", f"z=gyro_z_raw*{1 / 1310.72!r}:deg/s", "--rate", 1, "--set", "rate_hz=100"]
    code, out, err = cli("run", "rest", "--log", log, *words, "--out", "out")
    assert code == 0, (out, err)
    rows = found_in(here / "out")
    for how in ("curve", "likelihood"):
        answer = {
            "N": rows[f"z.N.{how}"].value,
            "K": rows[f"z.K.{how}"].value,
            "kalibr_noise_density": rows[f"z.gyroscope_noise_density.{how}"].value,
            "kalibr_random_walk": rows[f"z.gyroscope_random_walk.{how}"].value,
            "arw_deg_sqrt_h": rows[f"z.ARW.{how}"].value,
            "R_100Hz": rows["z.R"].value,
            "Q_100Hz": rows["z.Q"].value,
        }
        check("allan-static", answer, here)
    assert rows["z.K.likelihood"].low == pytest.approx(1.53e-4, rel=0.02)
    assert rows["z.K.likelihood"].high == pytest.approx(2.07e-4, rel=0.02)


@pytest.mark.parametrize(("study", "channel"), [("rest", "z"), ("kownacki2010", "a")])
def test_a_board_that_is_waved_about_is_not_at_rest(study, channel, cli, here):
    log = CASES / "moving-record" / "acc_x.csv"
    words = ["--log", log, "--map", f"{channel}=AccX_mg:mg", "--time", "time_ms:ms"]
    code, _, err = cli("run", study, *words, "--out", "out")
    assert code == 2
    refused = "acc_x.csv" in err and "is not at rest" in err
    check("moving-record", {"refused_or_warned": int(refused)}, here)


def test_trackers_gains_without_a_recording(cli, here):
    code, out, err = cli("run", CASES / "one-number-cv" / "one.toml", "--out", "out")
    assert code == 0, (out, err)
    rows = found_in(here / "out")
    names = ("Q11", "Q12", "Q22", "K1", "K2", "alpha", "beta")
    check("one-number-cv", {name: rows[name].value for name in names}, here)


def described(said, name):
    """What is told of a channel before anything is fitted: file's samples, rate, mean, std."""
    samples = int(re.search(r": (\d+) samples? at", said)[1])
    mean, std = map(float, re.search(rf"^{name} .* 0 +(\S+) +(\S+)", said, re.MULTILINE).groups())
    rate = float(re.search(r"samples? at (\S+) Hz", said)[1])
    return {"samples": samples, "rate_hz": rate, "mean": mean, "std": std}


@pytest.mark.parametrize("file", ["Messung_01.csv", "Messung_utf8bom.csv"])
def test_a_german_logger(file, cli, here):
    log = CASES / "log-german-logger" / file
    words = ["--filter", "local-level", "--map", "z=Temperatur [°C]", "--starts", 1, "--jobs", 1]
    code, out, err = cli("fit", log, *words, "--no-hold-out", "--out", "out")
    assert code == 0, (out, err)
    assert "decimal commas" in err + out
    check("log-german-logger", described(err + out, "z") | pressure(Answer(here / "out")), here)


def test_a_phone_at_rest_with_bursts(cli, here):
    told = {}
    for file in ("Gyroscope.csv", "GyroscopeBursts.csv"):
        log = CASES / "log-phone-zip" / file
        code, out, err = cli("run", "rest", "--log", log, "--map", "w=x:rad/s", "--out", file[:-4])
        assert code == 0, (out, err)
        told[file] = described(err + out, "w")
    bursts = told["GyroscopeBursts.csv"]
    more = {f"{name}_bursts": bursts[name] for name in ("samples", "rate_hz")}
    check("log-phone-zip", told["Gyroscope.csv"] | more, here)


def test_the_text_files_of_a_flight_controller(cli, here):
    home = CASES / "log-ulog2csv"
    logs = (home / "log_sensor_combined_0.csv", home / "log_vehicle_air_data_0.csv")
    words = ["--map", "w=gyro_rad[2]:rad/s", "--map", "a=accelerometer_m_s2[2]:m/s^2"]
    words += ["--log", logs[0], "--log", logs[1], "--map", "h=baro_alt_meter:m"]
    code, _, err = cli("run", "rest", *words, "--out", "out")
    assert code == 2
    assert "--time 'timestamp:us' (199.9 Hz)" in err
    code, out, err = cli("run", "rest", *words, "--time", "timestamp:us", "--out", "out")
    assert code == 0, (out, err)
    rows, told = found_in(here / "out"), described(err + out, "w")
    std = {name: rows[f"{at}.R"].value ** 0.5 for name, at in (("gyro", "w"), ("acc", "a"))}
    answer = {"gyro_samples": told["samples"], "rate_hz": told["rate_hz"]}
    answer |= {f"{name}_std": value for name, value in std.items()}
    check("log-ulog2csv", answer | {"baro_std": rows["h.R"].value ** 0.5}, here)
