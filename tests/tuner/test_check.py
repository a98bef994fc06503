"""tuner check: values in use on another recording, of a run or of the command line."""

import json

import numpy as np
import pytest

import tuner
from tests.tuner import fit_cases as cases

WORDS = ("--filter", "local-level", "--set", "q=0.09", "--set", "R=1")
READ = ("--map", "z=z:m")


def checked(cli, *words):
    code, out, err = cli("check", *words, "--json")
    assert code == 0, err
    return json.loads(out)


@pytest.fixture
def log(here):
    return cases.write(here / "level.csv", cases.level())


@pytest.fixture
def run(cli, here, log):
    code, _, err = cli(
        *("fit", log, "--filter", "local-level", *READ, "--starts", 1, "--no-hold-out"),
        *("--out", "run"),
    )
    assert code == 0, err
    return here / "run"


def test_values_of_the_command_line(cli, log):
    found = checked(cli, *WORDS, *READ, "--log", log)
    y, s = cases.level_loop(cases.level()["z"], 0.09, 1.0, 1.0)
    assert (found["schema"], found["filter"]) == ("tuner.check/1", "local-level")
    assert found["values"]["R"] == {"value": 1.0, "unit": "m^2"}
    assert found["log"]["name"] == "level.csv"
    judged = found["diagnostics"]
    assert judged["numbers"] == 399
    assert judged["nis"] == judged["factor"] == pytest.approx(np.mean(y**2 / s), rel=1e-9)
    tests = {each["test"]: each["verdict"] for each in judged["findings"]}
    assert tests.pop("full turns") == "not tried"
    assert set(tests.values()) == {"passed"}
    assert list(tests) == ["outliers", "start", "over level", "over time", "whiteness", "size"]


def test_wrong_values_are_told_and_are_no_failure(cli, log):
    code, out, err = cli(
        *("check", "--filter", "local-level", "--set", "q=9", "--set", "R=100", *READ),
        *("--log", log),
    )
    assert code == 0, err
    assert "all noise variances are too large by a factor" in out
    assert "local-level with q = 9 m^2/s, R = 100 m^2" in out


def test_values_of_a_run_on_another_recording(cli, here, run):
    other = cases.write(here / "other.csv", cases.level(seed=77))
    found = checked(cli, "run", "--log", other)
    tuned = json.loads((run / "result.json").read_text())["solutions"][0]["parameters"]
    values = {name: each["value"] for name, each in found["values"].items()}
    assert values == {name: each["value"] for name, each in tuned.items()}
    y, s = cases.level_loop(cases.level(seed=77)["z"], values["q"], values["R"], 1.0)
    assert found["diagnostics"]["nis"] == pytest.approx(np.mean(y**2 / s), rel=1e-9)
    assert found["log"]["name"] == "other.csv"
    assert not found["notes"]
    # The file result.json stands for its folder.
    assert checked(cli, "run/result.json", "--log", other) == found
    late = checked(cli, "run", "--log", other, "--from", 100)
    assert late["diagnostics"]["numbers"] == found["diagnostics"]["numbers"] - 100
    # On what it was tuned on, the same as the run says, and it is said.
    own = checked(cli, "run", "--log", here / "level.csv")
    assert "level.csv is what the run was tuned on" in own["notes"]
    now = json.loads((run / "result.json").read_text())["fit"]["diagnostics"][1]
    assert own["diagnostics"]["nis"] == now["nis"]


def test_a_gate_is_an_option_as_in_a_fit(cli, here):
    columns = cases.level()
    columns["z"][[100, 200, 300]] += 40.0
    log = cases.write(here / "wild.csv", columns)
    found = checked(cli, *WORDS, *READ, "--log", log)
    tests = {each["test"]: each for each in found["diagnostics"]["findings"]}
    assert tests["outliers"]["verdict"] == "failed"
    assert "--set gate=4" in tests["outliers"]["sentence"]
    gated = checked(cli, *WORDS, "--set", "gate=4", *READ, "--log", log)
    assert gated["options"] == {"gate": 4}
    assert gated["diagnostics"]["numbers"] == found["diagnostics"]["numbers"] - 3
    assert {f["verdict"] for f in gated["diagnostics"]["findings"]} == {"passed", "not tried"}


def test_with_a_truth_the_error(cli, here, log):
    found = checked(cli, *WORDS, *READ, "--truth", "level=level:m", "--log", log)
    level = cases.level()
    record = tuner.Record.of({"z": level["z"]}, rate_hz=1.0)
    check = tuner.check("local-level", record, {"q": 0.09, "R": 1.0})
    estimate = tuner.fit(
        "local-level", record, start={"q": 0.09}, fix={"R": 1.0}, starts=1, hold_out=False
    ).posed.problem
    assert found["objective"] == "rmse"
    assert 0.3 < found["value"] < 0.7  # a level of steady variance K R = 0.26
    assert found["diagnostics"]["nis"] == pytest.approx(check.diagnostics.nis, rel=1e-9)
    assert estimate.space.names == tuple(check.values)


def test_a_filter_without_innovations_needs_a_truth(cli, here):
    """And with one, its error is all there is to say."""
    log = cases.write(here / "imu.csv", cases.imu(seconds=4.0))
    maps = ("--map", "gyr=gx,gy,gz:rad/s", "--map", "acc=ax,ay,az:m/s^2")
    words = ("check", "--filter", "mahony", "--set", "Kp=1", "--set", "Ki=0.1", *maps)
    code, _, err = cli(*words, "--log", log)
    assert code == 2
    assert "mahony outputs no innovation and no variance" in err
    assert "give a truth for one of its outputs, such as --truth att=" in err
    code, out, err = cli(*words, "--log", log, "--truth", "att=q0,q1,q2,q3", "--json")
    assert code == 0, err
    found = json.loads(out)
    assert found["diagnostics"] is None
    assert found["objective"] == "inclination"
    assert found["value"] > 0


def test_a_filter_without_variances_is_judged_by_the_rest(cli, here):
    log = cases.write(here / "track.csv", cases.track())
    found = checked(
        *(cli, "--filter", "alpha-beta", "--set", "alpha=0.9", "--set", "beta=0.01"),
        *("--map", "z=x:m", "--log", log),
    )
    judged = found["diagnostics"]
    assert judged["nis"] is None
    tests = {each["test"]: each["verdict"] for each in judged["findings"]}
    assert (tests["size"], tests["whiteness"]) == ("not tried", "failed")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--filter", "local-level", "--set", "q=1"), "has no value in use for R"),
        (("--filter", "local-level", "--set", "p=1"), "parameter or option of local-level"),
        (("--filter", "local-level", "--set", "q=fast", "--set", "R=1"), "--set q is 'fast'"),
        (("--filter", "local-level", "--set", "q=true", "--set", "R=1"), "finite number"),
        (("--filter", "local-level", "--set", "q=-1", "--set", "R=1"), "it cannot be negative"),
        (("--filter", "level", "--set", "q=1"), "level"),
        ((), "name the run whose values are checked"),
        (("nowhere",), "nowhere"),
    ],
)
def test_refusals(cli, log, words, said):
    code, out, err = cli("check", *words, *READ, "--log", log)
    assert (code, out) == (2, "")
    assert said in err
    assert err.strip().count("\n") == err.strip().count("\n", 0, err.find("tuner: "))


def test_refusals_of_runs(cli, here, run, toy):
    other = cases.write(here / "other.csv", cases.level(seed=77))
    for words, said in (
        (("run",), "a check needs a recording"),
        (("run", "--log", other, "--set", "q=1"), "leave out --filter and --set"),
        (("run", "--log", other, "--map", "z=z"), "this recording makes it unit^2/s"),
    ):
        code, _, err = cli("check", *words)
        assert code == 2
        assert said in err
    # What was tuned in metres is no value in pascals.
    code, _, err = cli("check", "run", "--log", other, "--map", "z=z:Pa")
    assert code == 2
    assert "was tuned in m^2/s and this recording makes it Pa^2/s" in err
    assert cli("run", "toy", "--out", "toy")[0] == 0
    code, _, err = cli("check", "toy", "--log", other)
    assert code == 2
    assert "is a run of toy and not of tuner fit" in err


def test_from_python():
    level = cases.level()
    record = tuner.Record.of({"z": level["z"]}, rate_hz=1.0)
    found = tuner.check("local-level", record, {"q": 0.09, "R": 1.0})
    y, s = cases.level_loop(level["z"], 0.09, 1.0, 1.0)
    assert found.error == pytest.approx(cases.deviation(y, s), rel=1e-9)
    assert found.value == pytest.approx(cases.nats(y, s), rel=1e-9)
    assert not found.diagnostics.failed
    still = tuner.check("local-level", record, {"q": 0.0, "R": 1.0})  # a level that never moves
    assert still.diagnostics["whiteness"].verdict == "failed"
    both = tuner.check("local-level", [record, record], {"q": 0.09, "R": 1.0})
    assert both.diagnostics.numbers == 2 * found.diagnostics.numbers
    with pytest.raises(ValueError, match="no value in use for q"):
        tuner.check("local-level", record, {"R": 1.0})
