"""Every filter of the catalogue, tuned from a CSV file by one command, against what was simulated.

Tolerances: a variance that is estimated from n numbers has a relative deviation of sqrt(2/n), and
3.5 of these are allowed (simulations have one seed); a search that is held against another one of
the same numbers agrees to 1e-3 in the parameters, whose objective is flat there to 1e-6.
"""

import importlib.util
import json
from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy.optimize import minimize

from filters.declared import parameter_facts
from tests.example_package.installed import install
from tests.tuner import fit_cases as cases
from tuner.catalogue import find, names
from tuner.export import FORMATS

SIX = ("--map", "gyr=gx,gy,gz:rad/s", "--map", "acc=ax,ay,az:m/s^2")
FORWARD_RIGHT_DOWN = ("--map", "gyr=gx,-gy,-gz:rad/s", "--map", "acc=ax,-ay,-az:m/s^2")
QUATERNION = ("--truth", "att=q0,q1,q2,q3")


def within(values, truth, numbers):
    """Each value within 3.5 relative deviations of a variance from so many numbers."""
    for name, true in truth.items():
        assert values[name] == pytest.approx(true, rel=3.5 * np.sqrt(2 / numbers)), name


@dataclass(frozen=True)
class Case:
    """A command for a filter: its recording, mappings and options.

    ``free``: the parameters that are tuned, the rest held at their typical values; all if empty.
    """

    data: str
    words: tuple[str, ...]
    check: str
    free: tuple[str, ...] = ()
    truth: dict[str, float] = field(default_factory=dict)
    numbers: int = 0


CASES = {
    "local-level": Case("level", ("--map", "z=z"), "likelihood_by_hand"),
    "constant-velocity": Case("track", ("--map", "x=x:m"), "likelihood_by_hand"),
    "constant-acceleration": Case("track", ("--map", "x=x:m", "--map", "y=y:m"), "improved"),
    "alpha-beta": Case("track", ("--map", "z=x:m"), "gains_by_hand"),
    "alpha-beta-gamma": Case("jerks", ("--map", "z=x:m"), "gains_by_hand"),
    "vertical": Case(
        "climb",
        ("--map", "acc=acc:m/s^2", "--map", "baro=baro:m"),
        "known_noise",
        truth={"R_baro": 0.09},
        numbers=200,
    ),
    "complementary": Case(
        "imu",
        ("--map", "rate=rate:rad/s", "--map", "angle=angle:rad", "--truth", "angle=roll:rad"),
        "tau_by_hand",
    ),
    "mahony": Case("imu", (*SIX, *QUATERNION), "improved"),
    "madgwick": Case("imu", (*SIX, *QUATERNION), "beta_by_hand"),
    "attitude": Case(
        "calm",
        (*SIX, "--fix", "delta=0.5"),
        "known_noise",
        free=("accelerometer",),
        truth={"accelerometer": (cases.ACC_NOISE / 9.81) ** 2},
        numbers=3 * 600,
    ),
    "bounded-motion": Case("short", (*SIX, *QUATERNION), "improved", free=("accelerometer",)),
    "tilt": Case(
        "calm",
        (*SIX, "--set", "law=standard"),
        "known_noise",
        free=("q1", "r_nom", "r3"),
        # The rates change smoothly, not by white noise as the filter has it, so that q1 and r3
        # share their noise; that of the accelerometers is their own.
        truth={"r_nom": (cases.ACC_NOISE / 9.81) ** 2},
        numbers=2 * 600,
    ),
    "pi-complementary": Case(
        "imu",
        (*FORWARD_RIGHT_DOWN, "--map", "airspeed=speed:m/s", "--truth", "angles=roll,pitch:rad"),
        "improved",
    ),
    "gps-aided": Case(
        "imu",
        (*FORWARD_RIGHT_DOWN[:2], "--map", "angles=mroll,mpitch,myaw:rad"),
        "known_noise",
        free=("R_phi", "R_theta", "R_psi"),
        truth=dict.fromkeys(("R_phi", "R_theta", "R_psi"), cases.ANGLE_NOISE**2),
        numbers=200,
    ),
    "dead-reckoning": Case(
        "imu",
        (
            *("--map", "speed=speed:m/s", "--map", "angles=roll,pitch,yaw:rad"),
            *("--map", "position=north,east,down:m"),
        ),
        "known_noise",
        free=("R_horizontal", "R_down"),
        truth={"R_horizontal": 1.0, "R_down": 1.0},
        numbers=120,
    ),
    "ins": Case(
        "calm",
        (*SIX, "--map", "gps=sx,sy,sz:m"),
        "known_noise",
        free=("R_gps", "R_gps_up"),
        truth={"R_gps": 0.25, "R_gps_up": 0.25},
        numbers=120,
    ),
    "gauss-markov": Case("level", ("--map", "z=z"), "markov_by_hand"),
}


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    made = {
        "level": cases.level(),
        "track": cases.track(),
        "jerks": cases.jerks(),
        "climb": cases.climb(),
        "imu": cases.imu(),
        "short": cases.imu(seconds=3.0),
        "calm": cases.imu(bursts=False),
    }
    return {name: (cases.write(folder / f"{name}.csv", data), data) for name, data in made.items()}


def command(filter, file, case):
    words = ["fit", file, "--filter", filter, *case.words, "--out", "out"]
    given = {word.partition("=")[0] for word in case.words}
    if case.free:
        for name, fact in parameter_facts(find("tuner.filters", filter)).items():
            if fact.low is not None and name not in case.free and name not in given:
                words += ["--fix", f"{name}={fact.typical}"]
    return [*words, "--starts", 1, "--no-hold-out", "--jobs", 1]


@pytest.mark.parametrize("filter", sorted({*names("tuner.filters"), "gauss-markov"}))
def test_a_filter_is_tuned_by_one_command(filter, cli, here, recordings, tmp_path, monkeypatch):
    if filter == "ins" and importlib.util.find_spec("filters.ins") is None:
        pytest.skip("the error-state INS has no module yet")
    if filter == "gauss-markov":  # of another package, found by its entry point
        (tmp_path / "site").mkdir()
        monkeypatch.syspath_prepend(str(install(tmp_path / "site")))
    assert filter in CASES, f"{filter} has no case here; add its recording and what is true of it"
    case = CASES[filter]
    file, data = recordings[case.data]
    code, out, err = cli(*command(filter, file, case))
    assert code == 0, (out, err)
    result = json.loads((here / "out" / "result.json").read_text())
    (solution,) = result["solutions"]
    values = {name: parameter["value"] for name, parameter in solution["parameters"].items()}
    assert solution["status"] == "converged"
    assert result["fit"]["tuned"] < result["fit"]["start"]
    assert len(result["exports"]) == len(FORMATS)
    assert result["single_precision"]
    outputs = np.load(here / "out" / "outputs.npz")
    assert result["fit"]["tuned"] == pytest.approx(told(result, outputs, data), rel=1e-9)
    globals()[case.check](case, data, values, result)


def told(result, outputs, data):
    """The objective by hand, from the outputs that were written down."""
    objective = result["fit"]["objective"]
    if objective == "likelihood":
        counted = outputs["variance"] > 0
        return cases.deviation(outputs["innovation"][counted], outputs["variance"][counted])
    if objective == "prediction":
        return np.sqrt(np.mean(outputs["innovation"] ** 2))
    if objective == "inclination":
        truth = np.stack([data[f"q{i}"] for i in range(4)], axis=1)
        return cases.inclination_rms(outputs["att"], truth)
    name = "angle" if "angle" in outputs else "angles"
    columns = ("roll",) if name == "angle" else ("roll", "pitch")
    error = outputs[name].reshape(len(data["t"]), -1) - np.stack([data[c] for c in columns], axis=1)
    return np.sqrt(np.mean((error**2).sum(axis=1)))


# What is true of a filter.


def improved(case, data, values, result):
    """Better than where it began; that the search ended at an optimum, its certificate says."""
    (solution,) = result["solutions"]
    gradient = solution["certificate"]["gradient"].values()
    assert max(abs(g) for g in gradient) < 1e-3
    assert result["fit"]["tuned"] < 0.99 * result["fit"]["start"]


def known_noise(case, data, values, result):
    within(values, case.truth, case.numbers)


def likelihood_by_hand(case, data, values, result):
    z, loop, dt = (
        (data["z"], cases.level_loop, 1.0)
        if case.data == "level"
        else (data["x"], cases.velocity_loop, cases.TRACK_DT)
    )
    best, value = cases.tuned_by_hand(lambda q, R: loop(z, q, R, dt), [0.5, 2.0])
    assert [values["q"], values["R"]] == pytest.approx(best, rel=1e-3)
    assert result["fit"]["tuned"] == pytest.approx(value, rel=1e-6)


def gains_by_hand(case, data, values, result):
    """The same gains by another search over a textbook loop; nothing predicts the first sample."""
    count, dt = len(values), cases.TRACK_DT
    scale = np.array([1.0, 1 / dt, 1 / (2 * dt**2)])[:count]
    z = data["x"]

    def cost(logs):
        found = cases.gains_loop(z, np.exp(logs) * scale, dt)
        return np.log(np.mean(found**2)) / 2 if np.isfinite(found).all() else 1e3

    gains = np.array(list(values.values()))
    other = minimize(cost, np.log(gains * 1.2), method="Nelder-Mead", options={"xatol": 1e-7})
    assert gains == pytest.approx(np.exp(other.x), rel=1e-2)
    # Ours counts one innovation of 0 more, that of the first sample.
    ours = result["fit"]["tuned"] * np.sqrt(len(z) / (len(z) - 1))
    assert ours == pytest.approx(np.exp(other.fun), rel=1e-6)


def tau_by_hand(case, data, values, result):
    def rms(log):
        found = cases.mixed_angle(data["rate"], data["angle"], np.exp(log[0]), 0.02)
        return np.sqrt(np.mean((found - data["roll"]) ** 2))

    other = minimize(rms, [0.0], method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-14})
    assert values["tau"] == pytest.approx(np.exp(other.x[0]), rel=1e-3)
    assert result["fit"]["tuned"] == pytest.approx(other.fun, rel=1e-9)


def beta_by_hand(case, data, values, result):
    gyr = np.stack([data[f"g{axis}"] for axis in "xyz"], axis=1)
    acc = np.stack([data[f"a{axis}"] for axis in "xyz"], axis=1)
    truth = np.stack([data[f"q{i}"] for i in range(4)], axis=1)

    def rms(beta):
        return cases.inclination_rms(cases.madgwick_loop(gyr, acc, beta, 0.02), truth)

    beta = values["beta"]
    # The loop's own objective is as low there, and higher to both sides.
    assert rms(beta) == pytest.approx(result["fit"]["tuned"], rel=1e-3)
    assert min(rms(0.9 * beta), rms(1.1 * beta)) > rms(beta)


def markov_by_hand(case, data, values, result):
    """x' = a x + w with a steady variance of sigma^2, which is also that of the start."""
    z = data["z"]

    def loop(tau, sigma, R):
        x, P, found = 0.0, sigma**2, []
        for zk in z:
            a = np.exp(-1 / tau)
            x, P = a * x, a * a * P + sigma**2 * (1 - a * a)
            s = P + R
            found.append((zk - x, s))
            x, P = x + P / s * (zk - x), P * R / s
        return np.array(found).T

    best, value = cases.tuned_by_hand(loop, [20.0, 2.0, 1.0])
    assert [values[name] for name in ("tau", "sigma", "R")] == pytest.approx(best, rel=1e-2)
    assert result["fit"]["tuned"] == pytest.approx(value, rel=1e-6)
