"""Noise in the files of kalibr, PX4, ArduPilot and robot_localization, by tuner export."""

import math
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.tuner.firmware_cases import (
    axis,
    filter_of,
    read_ardupilot,
    read_px4,
    save_run,
    vertical,
)
from tuner.firmware import TARGETS, Amount, ardupilot, kalibr, px4
from tuner.firmware.amount import density, deviation
from tuner.run.at_rate import filter_at_rate
from tuner.run.filter_choice import choose_filter

OK = "--accept-approximate"
TO_A_FILTER = ("px4", "ardupilot", "robot_localization")


@pytest.fixture
def written(cli):
    """Export a run to stdout: the text and what was said."""

    def run(to, *arguments, folder="run"):
        code, out, err = cli("export", folder, "--to", to, "-o", "-", *arguments)
        assert code == 0, err
        assert out.isascii()
        return out, err.splitlines()

    return run


@pytest.fixture
def refused(cli):
    """The sentence by which an export of a run is refused; nothing is written."""

    def run(to, *arguments, folder="run"):
        before = sorted(Path().iterdir())
        code, out, err = cli("export", folder, "--to", to, *arguments)
        assert (code, out) == (2, ""), err
        assert sorted(Path().iterdir()) == before
        (line,) = err.splitlines()
        return line.removeprefix("tuner: ")

    return run


# Conversions.


@pytest.mark.parametrize(
    ("value", "unit"),
    [
        (4e-6, "rad^2/s"),
        (4e-6, "(rad/s)^2/Hz"),
        (2e-3, "rad/s/sqrt(Hz)"),
        (2e-3, "rad/s^0.5"),
        (math.degrees(2e-3), "deg/s/sqrt(Hz)"),
        (math.degrees(2e-3) * 60, "deg/h^0.5"),
        (4e-6 / 0.02, "(rad/s)^2"),  # of a sample at 50 Hz
        (2e-3 / math.sqrt(0.02), "rad/s"),
    ],
)
def test_a_density_in_any_unit(value, unit):
    found = density(Amount("x", value, unit, "", 0.02), "rad/s")
    assert found.value == pytest.approx(2e-3, rel=1e-14)


@pytest.mark.parametrize("unit", ["", "unit^2", "1/s", "rad", "m^2/s^3", "rad^2", "what/ever", "^"])
def test_units_that_are_no_such_density(unit):
    assert density(Amount("x", 1.0, unit, "", 0.02), "rad/s") is None
    assert deviation(Amount("x", 1.0, unit, "", 0.02), "m") is None


def test_what_belongs_to_no_sample_time_is_no_density():
    assert density(Amount("R", 1.0, "(rad/s)^2", "", 0.0), "rad/s") is None


def test_deviations_of_measurements():
    assert deviation(Amount("R", 9e-14, "T^2", "", 0.0), "gauss").value == pytest.approx(3e-3)
    assert deviation(Amount("s", 30.0, "cm", "", 0.0), "m").value == pytest.approx(0.3)


@pytest.mark.parametrize(("target", "T"), [(px4, 0.01), (ardupilot, 0.012), (px4, 0.004)])
def test_variance_grows_in_the_firmware_as_it_does_by_the_density(target, T):
    """Both add (T sigma)^2 a prediction; the variance of a walk of density N is N^2 t at t."""
    units = {"rad/s": "rad", "m/s^2": "m/s", "rad/s^2": "rad/s", "m/s^3": "m/s^2"}
    N, steps = 3e-3, 1000
    for key in target.KEYS[:4]:
        assert key.unit in units
        sigma = key.of(Amount("N", N, f"{key.unit}/sqrt(Hz)", "", 0.0), T).value
        variance = 0.0
        for _ in range(steps):
            variance += (T * sigma) ** 2
        assert variance == pytest.approx(N**2 * steps * T, rel=1e-12)


# Of a record at rest.


def test_kalibr_has_what_was_found_at_rest(written, here):
    save_run(
        "run", axis("gyr", "rad/s", 1e-5, 2e-06), axis("acc", "m/s^2", 2e-3, 3e-4), rate_hz=200
    )
    text, said = written("kalibr")
    assert yaml.safe_load(text) == {
        "accelerometer_noise_density": 2e-3,
        "accelerometer_random_walk": 3e-4,
        "gyroscope_noise_density": 1e-5,
        "gyroscope_random_walk": 2e-6,
        "update_rate": 200.0,
    }
    assert said == []


def test_kalibr_is_told_what_is_missing(written, here):
    save_run("run", axis("gyr", "rad/s", 1e-5, 1e-8, below=3e-7), rate_hz=0.0)
    text, said = written("kalibr")
    assert yaml.safe_load(text) == {"gyroscope_noise_density": 1e-5}
    assert said == [
        "random_walk is left out: the record does not tell it from 0, it is below 3e-07 "
        "rad/s/s/sqrt(Hz); --map random_walk=gyroscope_random_walk writes 1e-08 all the same",
        "kalibr needs accelerometer_noise_density, accelerometer_random_walk, "
        "gyroscope_random_walk too: fill it in",
        "the rate of the record is not known: give --rate HZ, or fill update_rate in",
    ]
    for name in ("accelerometer_noise_density", "gyroscope_random_walk", "update_rate"):
        assert f"\n#{name}:\n" in text
    text, _ = written("kalibr", "--map", "random_walk=gyroscope_random_walk", "--rate", "400")
    assert yaml.safe_load(text)["gyroscope_random_walk"] == 1e-8
    assert yaml.safe_load(text)["update_rate"] == 400.0
    assert "which the record does not tell from 0, it is below 3e-07 rad/s/s/sqrt(Hz)" in text


def three_axes():
    """The gyroscope's third axis shows no random walk."""
    return [
        axis("gyr_x", "rad/s", 1e-3, 1e-5),
        axis("gyr_y", "rad/s", 2e-3, 2e-5),
        axis("gyr_z", "rad/s", 4e-3, 0.0, below=1e-5),
    ]


@pytest.mark.parametrize(
    ("axes", "white", "walk"),
    [("largest", 4e-3, 2e-5), ("rms", math.sqrt(21e-6 / 3), math.sqrt(5e-10 / 2))],
)
def test_several_axes_are_one_number_as_is_asked(written, here, axes, white, walk):
    save_run("run", *three_axes())
    found = yaml.safe_load(written("kalibr", "--axes", axes)[0])
    assert found["gyroscope_noise_density"] == pytest.approx(white, rel=1e-14)
    assert found["gyroscope_random_walk"] == pytest.approx(walk, rel=1e-14)
    text, said = written("px4", "--axes", axes, OK)
    assert read_px4(text) == {
        "EKF2_GYR_NOISE": pytest.approx(10 * white, rel=1e-8),
        "EKF2_GYR_B_NOISE": pytest.approx(10 * walk, rel=1e-8),
    }
    assert said == [
        "gyr_z.random_walk is left out: the record shows none, it is below 1e-05 rad/s/s/sqrt(Hz)"
    ]


def test_several_axes_are_asked_about(refused, written, here):
    save_run("run", *three_axes())
    assert refused("kalibr") == (
        "gyr_x.noise_density, gyr_y.noise_density and gyr_z.noise_density each give "
        "gyroscope_noise_density, which is one number for all of them; give --axes largest or "
        "--axes rms, or one of them: --map gyr_x.noise_density=gyroscope_noise_density"
    )
    assert refused("kalibr", "--axes", "mean") == "--axes is 'mean'; give largest or rms"
    text, _ = written("kalibr", "--problem", "gyr_y")
    assert yaml.safe_load(text)["gyroscope_noise_density"] == 2e-3
    maps = ["--map", "gyr_y.noise_density=gyroscope_noise_density", "--axes", "largest"]
    assert yaml.safe_load(written("kalibr", *maps)[0])["gyroscope_noise_density"] == 2e-3


# Of a fit.


def test_what_parameters_declare_is_known_and_the_rest_is_asked_for(written, here):
    save_run("run", vertical())
    text, said = written("ardupilot", OK)
    T = 0.012
    assert read_ardupilot(text) == {
        "EK3_ACC_P_NSE": pytest.approx(0.02 / math.sqrt(T), rel=1e-8),
        "EK3_ABIAS_P_NSE": pytest.approx(3e-5 / math.sqrt(T), rel=1e-8),
    }
    assert said == [
        "left out: R_baro (m^2, variance of the barometer's height) may be EK3_ALT_M_NSE, "
        "EK3_POSNE_M_NSE or EK3_RNG_M_NSE: --map R_baro=EK3_ALT_M_NSE if it is"
    ]
    assert "sqrt(q_acc) / sqrt(0.012 s) = 0.182574 m/s^2, q_acc = 0.0004 m^2/s^3" in text
    text, said = written("ardupilot", OK, "--map", "R_baro=EK3_ALT_M_NSE")
    assert read_ardupilot(text)["EK3_ALT_M_NSE"] == 0.5
    assert said == []


def test_another_rate_of_predictions(written, here):
    save_run("run", vertical())
    text, _ = written("px4", OK, "--rate", "250")
    assert read_px4(text)["EKF2_ACC_NOISE"] == pytest.approx(0.02 * math.sqrt(250), rel=1e-8)
    assert "EKF2_PREDICT_US = 4000." in text


def test_what_is_not_determined_is_left_out_unless_it_is_named(written, refused, here):
    folder = save_run("run", vertical(), intervals={"q_acc": (0.0, 1e-3), "q_bias": (None, None)})
    told = refused("px4", OK)
    assert told.startswith("nothing says which numbers of vertical (fit, flight.csv) PX4 takes: ")
    for words in (
        "q_acc is left out: the record does not tell it from 0, it is below 0.001 m^2/s^3; --map",
        "q_bias is left out: the record does not tell it from 0; --map q_bias=EKF2_ACC_B_NOISE",
        "R_baro (m^2, ",
    ):
        assert words in told
    text, _ = written("px4", OK, "--map", "q_acc=EKF2_ACC_NOISE", folder=folder)
    assert read_px4(text) == {"EKF2_ACC_NOISE": pytest.approx(0.2)}


def test_ends_of_the_firmware_hold_and_are_told(written, here):
    save_run("run", vertical(q_acc=1e-8, R=900.0))
    text, said = written("px4", OK, "--map", "R_baro=EKF2_BARO_NOISE")
    found = read_px4(text)
    assert found["EKF2_ACC_NOISE"] == 0.01
    assert found["EKF2_BARO_NOISE"] == 15.0
    assert said == [
        "EKF2_ACC_NOISE would be 0.001 m/s^2, and the firmware takes 0.01 to 1: 0.01 is written",
        "EKF2_BARO_NOISE would be 30 m, and the firmware takes 0.01 to 15: 15 is written",
    ]
    assert all(f"# {line}\n" in text for line in said)


def test_numbers_of_vectors_and_matrices_have_the_names_of_findings(written, here):
    one = filter_of("gps", {"R": ([4.0, 0.25], "m^2, (m/s)^2"), "S": (np.eye(2), "rad^2")})
    save_run("run", (one, []))
    maps = ["R1=EKF2_GPS_P_NOISE", "R2=EKF2_GPS_V_NOISE", "S22=EKF2_HEAD_NOISE"]
    text, _ = written("px4", OK, *(word for pair in maps for word in ("--map", pair)))
    assert read_px4(text) == {
        "EKF2_GPS_P_NOISE": 2.0, "EKF2_GPS_V_NOISE": 0.5, "EKF2_HEAD_NOISE": 1.0
    }  # fmt: skip


# robot_localization.


def tracked(rate_hz=50.0):
    """A model of height, climb and bias at a rate."""
    values, _ = vertical()
    return filter_at_rate(choose_filter("vertical"), {}, values, rate_hz).tuned


def matrix(text):
    """The 15 x 15 numbers, which ROS takes as doubles alone, and the frequency."""
    (node,) = yaml.safe_load(text).values()
    found = node["ros__parameters"]
    numbers = found["process_noise_covariance"]
    assert len(numbers) == 225
    assert all(type(number) is float for number in numbers)
    return np.reshape(numbers, (15, 15)), found.get("frequency")


STATES = "x y z roll pitch yaw vx vy vz vroll vpitch vyaw ax ay az".split()  # noqa: SIM905


@pytest.mark.parametrize("rate", [50.0, 30.0])
def test_a_prediction_of_robot_localization_adds_what_the_model_adds(written, here, rate):
    """M T = Q by van Loan's closed form of the channel: climb is driven by q, bias left out."""
    settings = {"filter": "vertical"}
    save_run("run", (tracked(), []), settings=settings)
    maps = ("--map", "height=z", "--map", "climb=vz")
    text, said = written("robot_localization", OK, *maps, *(["--rate", "30"] * (rate == 30)))
    found, frequency = matrix(text)
    assert frequency == pytest.approx(rate, rel=1e-15)
    T, q, b = 1 / rate, 4e-4, 9e-10
    Q = q * np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])
    Q += b * np.array([[T**5 / 20, T**4 / 8], [T**4 / 8, T**3 / 3]])
    block = np.ix_([2, 8], [2, 8])
    np.testing.assert_allclose(found[block] * T, Q, rtol=1e-9)
    own = np.diag([0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04, 0.01, 0.01, 0.02,
                   0.01, 0.01, 0.015])  # fmt: skip
    found[block] = own[block]
    np.testing.assert_array_equal(found, own)
    assert np.linalg.eigvalsh(matrix(text)[0]).min() > 0
    assert "x, y, roll, pitch, yaw, vx, vy, vroll" in said[-1]


def test_like_axes_have_the_covariance_of_one_each(written, refused, here):
    """As constant-velocity has for the axes xy; as many states of other names have not."""
    Q = np.array([[1.0, 2.0], [2.0, 5.0]])
    states = ["position_x", "position_y", "velocity_x", "velocity_y"]
    save_run("run", (filter_of("track", {"Q": (Q, "")}, states, dt=0.5), []))
    maps = [f"--map={s}={key}" for s, key in zip(states, ("y", "x", "vy", "vx"), strict=True)]
    found, frequency = matrix(written("robot_localization", OK, *maps)[0])
    assert frequency == 2.0
    for axes in (["x", "vx"], ["y", "vy"]):
        block = [STATES.index(name) for name in axes]
        np.testing.assert_array_equal(found[np.ix_(block, block)], 2 * Q)
    assert found[0, 1] == found[0, 7] == found[1, 6] == 0
    save_run("other", (filter_of("track", {"Q": (Q, "")}, ["x", "vx", "y", "vy"]), []))
    told = refused("robot_localization", OK, "--map", "x=x", folder="other")
    assert told.startswith("track has no covariance Q a sample of its states x, vx, y, vy; map")


def test_a_parameter_named_q_may_be_a_density(written, refused, here):
    one = filter_of("level", {"Q": (0.5, "m^2/s")}, ["height"])
    save_run("run", (one, []), derived=())
    assert "level has no covariance Q" in refused("robot_localization", OK, "--map", "height=z")
    assert matrix(written("robot_localization", OK, "--map", "Q=z")[0])[0][2, 2] == pytest.approx(
        0.5
    )
    save_run("other", (one, []))
    text, _ = written("robot_localization", OK, "--map", "height=z", folder="other")
    assert matrix(text)[0][2, 2] == pytest.approx(25.0)


def test_densities_of_robot_localization(written, here):
    save_run("run", (filter_of("robot", {"q": (0.3, "rad^2/s^3"), "p": (0.1, "m/s^2/Hz^0.5")}), []))
    text, _ = written("robot_localization", OK, "--map", "q=vyaw", "--map", "p=vx,vy")
    found, frequency = matrix(text)
    assert frequency is None
    places = [STATES.index(name) for name in ("vyaw", "vx", "vy")]
    np.testing.assert_allclose(np.diagonal(found)[places], [0.3, 0.01, 0.01], rtol=1e-12)


@pytest.mark.parametrize(
    ("maps", "words"),
    [
        ([], "what the states of vertical are to robot_localization, its states are height, climb"),
        (["height=vzz"], "unknown state of robot_localization 'vzz'; did you mean vz?"),
        (["heigt=z"], "unknown state or number 'heigt'; did you mean height?"),
        (["height=z,y"], "height is one state; map it to one of z and y"),
        (
            ["height=z"],
            "vertical has no covariance Q a sample of its states height, climb, bias; map",
        ),
        (["R_baro=z"], "R_baro is 0.25 m^2, and z takes a positive density in (m)^2/s"),
        (["climb0=z"], None),
    ],
)
def test_robot_localization_refuses(written, refused, here, maps, words):
    save_run("run", vertical())
    arguments = [OK, *(word for pair in maps for word in ("--map", pair))]
    if words is None:  # a deviation of a speed a sample is a noise of white steps
        assert matrix(written("robot_localization", *arguments)[0])[0][2, 2] == pytest.approx(0.02)
    else:
        assert words in refused("robot_localization", *arguments)


# What is refused.


@pytest.mark.parametrize("to", TO_A_FILTER)
def test_values_for_another_filter_have_to_be_accepted(refused, here, to):
    save_run("run", vertical())
    told = refused(to, "--map", "q_acc=vz") if to == "robot_localization" else refused(to)
    assert "is another filter than Any, so these are initial values" in told
    assert told.endswith("--accept-approximate writes them")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--map", "R_baro"], "--map R_baro has no value; write --map NAME=KEY"),
        (["--map", "R_baro=A,"], "--map R_baro=A, has no value; write --map NAME=KEY"),
        (["--map", "R=EKF2_BARO_NOISE"], "unknown number 'R'; there are: R_baro, bias0, "),
        (["--map", "R_baro=EKF2_BARO_NOIS"], "did you mean EKF2_BARO_NOISE"),
        (["--map", "R_baro=EKF2_X\nEKF2_Y"], "unknown parameter 'EKF2_X\\nEKF2_Y'"),
        (["--map", "R_baro=EKF2_GYR_NOISE"],
         "R_baro is in m^2, which is not a noise of rad/s as EKF2_GYR_NOISE is; map another"),
        (["--map", "q_acc=EKF2_ACC_NOISE", "--map", "R_baro=EKF2_ACC_NOISE"],
         "--map gives EKF2_ACC_NOISE twice, of q_acc and R_baro, and it is one; map it once"),
        (["--map", "R_baro=EKF2_BARO_NOISE", "--map", "R_baro=EKF2_GPS_P_NOISE"],
         "--map names R_baro twice; write --map R_baro=KEY,KEY"),
        (["--rate", "0"], "--rate is 0; give a positive number of samples a second"),
        (["--rate", "nan"], "--rate is nan; give a positive number"),
        (["--precision", "float"], "--precision and --tunable need --to c"),
        (["--rate", "9", "--density", "R_baro"], "--density does not apply to px4"),
        (["--problem", "vertica"], "unknown problem 'vertica'; did you mean vertical?"),
        (["-o", "nowhere/x.params"], "nowhere/x.params cannot be written"),
    ],
)  # fmt: skip
def test_wishes_that_cannot_be_met(refused, here, arguments, words):
    save_run("run", vertical())
    assert words in refused("px4", OK, *arguments)


@pytest.mark.parametrize("value", [0.0, -4.0])
def test_what_is_no_size_of_a_noise(refused, here, value):
    save_run("run", vertical(R=value))
    told = refused("px4", OK, "--map", "R_baro=EKF2_BARO_NOISE")
    assert told == (
        f"R_baro is {value:g}, and EKF2_BARO_NOISE is the size of a noise; map a positive number"
    )


def test_a_negative_density_is_no_noise(refused, here):
    _, findings = vertical()
    changed = filter_of("vertical", {"q_acc": (-1.0, "m^2/s^3")})
    save_run("run", (changed, findings))
    assert "q_acc is -1, and EKF2_ACC_NOISE is the size of a noise" in refused("px4", OK)


def test_numbers_that_are_none(refused, here):
    save_run("run", vertical(q_acc=0.125))
    file = Path("run/result.json")
    file.write_text(file.read_text().replace("0.125", "NaN"))
    assert "NaN" in refused("px4", OK) or "no result" in refused("px4", OK)


def test_a_filter_without_a_meaning_there(refused, here):
    save_run("run", (filter_of("mixer", {"tau": (0.5, "s"), "K": (0.1, "")}), []))
    for to in ("kalibr", "px4", "ardupilot"):
        told = refused(to, OK)
        assert told.startswith("nothing says which numbers of mixer (fit, flight.csv) ")
        assert told.endswith("by their units none is the size of such a noise")


def test_files_are_not_replaced(cli, refused, here):
    save_run("run", vertical())
    assert cli("export", "run", "--to", "px4", OK)[::2] == (
        0,
        "left out: R_baro (m^2, variance of the barometer's height) may be EKF2_BARO_NOISE, "
        "EKF2_GPS_P_NOISE or EKF2_RNG_NOISE: --map R_baro=EKF2_BARO_NOISE if it is\n"
        "wrote px4.params: 2 parameters\n",
    )
    before = Path("px4.params").read_bytes()
    assert "px4.params exists; give another name, or replace it with --force" in refused("px4", OK)
    assert Path("px4.params").read_bytes() == before
    assert cli("export", "run", "--to", "px4", OK, "--force", "--rate", "50")[0] == 0
    assert Path("px4.params").read_bytes() != before


def test_what_did_not_converge_needs_force(refused, written, here):
    save_run("run", vertical(status="stalled"))
    assert "the solution of vertical is 'stalled', not converged" in refused("px4", OK)
    assert read_px4(written("px4", OK, "--force")[0])


def test_formats_of_both_kinds_are_near(refused, here):
    save_run("run", vertical())
    assert "unknown format 'px5'; did you mean px4?" in refused("px5")


def test_options_of_firmware_alone(refused, here):
    save_run("run", vertical())
    for option in (["--map", "R_baro=X"], ["--axes", "rms"], [OK]):
        told = refused("json", *option)
        assert told.endswith("need --to kalibr|robot_localization|px4|ardupilot")


EVIL = "a\n1\t1\tEKF2_EN\t0\t9\r\u2028EK3_ENABLE,0\n- x: {y: ]\x85'\"\N{ROCKET}"


@pytest.mark.parametrize("to", [*TO_A_FILTER, "kalibr"])
def test_no_text_of_a_run_becomes_a_line_of_the_file(written, here, to):
    """Neither the log's name, nor the study's, nor a meaning, nor a unit that is none."""
    one, findings = vertical(log_name=EVIL, study=EVIL)
    strange = {"q_acc": (4e-4, "m^2/s^3", EVIL), "b": (1.0, EVIL, EVIL)}
    run = replace(one, quantities=filter_of("vertical", strange).quantities)
    save_run("run", (run, findings))
    maps = ["--map", "q_acc=vz"] if to == "robot_localization" else []
    text, _ = written(to, OK, *maps)
    lines = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
    assert not any("EK3_ENABLE" in line or "EKF2_EN\t" in line or "{y" in line for line in lines)
    if to == "px4":
        assert read_px4(text).keys() == {"EKF2_ACC_NOISE"}
    elif to == "ardupilot":
        assert read_ardupilot(text).keys() == {"EK3_ACC_P_NSE"}
    else:
        assert yaml.safe_load(text)


def test_keys_are_each_named_once():
    for keys in (px4.KEYS, ardupilot.KEYS, kalibr.KEYS):
        assert len({key.name for key in keys}) == len(keys)
        assert all(0 <= key.low < key.high and len(key.name) <= 27 for key in keys)
    assert all(len(key.name) <= 16 for key in (*px4.KEYS, *ardupilot.KEYS))  # MAVLink's limit


def test_the_commands_of_its_page_write_what_they_say(cli, here):
    page = Path(__file__).parents[2] / "docs" / "firmware.md"
    lines = re.findall(r"^tuner (export .+)$", page.read_text(), re.MULTILINE)
    (here / "runs").mkdir()
    save_run("imu", *three_axes(), axis("acc", "m/s^2", 2e-3, 3e-4))
    save_run("runs/fit-001", (tracked(), vertical()[1]))
    for line in lines:
        code, _, err = cli(*shlex.split(line, comments=True))
        assert code == 0, err
    for target in TARGETS.values():
        assert Path(target.file).is_file()
    for target in (px4, ardupilot):  # every parameter that the page names there is one
        named = re.findall(r"`((?:EKF2|EK3)_\w+(?:NOISE|NSE|NSD))`", page.read_text())
        own = {key.name for key in target.KEYS}
        assert own >= {name for name in named if name[:4] == next(iter(own))[:4]}
