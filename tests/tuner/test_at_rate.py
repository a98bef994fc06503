"""A tuned filter at another rate, against closed forms and scipy's Riccati solver."""

import json
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array
from scipy.linalg import expm, solve_discrete_are

from filters import Channel, LinearForm, Measured, Param, Transition
from tests.tuner import fit_cases as cases
from tuner.export.tuned import Provenance, Quantity, Tuned
from tuner.run.at_rate import filter_at_rate
from tuner.run.filter_choice import FilterChoice, choose_filter

RATES = (0.5, 1.0, 12.5, 60.0, 1000.0)
SOURCE = Provenance("fit", "x", "known", "converged", 0, "", "", ())


def tuned(values, dt, filter="X"):
    quantities = tuple(Quantity(n, np.array(v), u) for n, (v, u) in values.items())
    return Tuned("x", filter, quantities, "discrete", dt, (), SOURCE)


def at(name, values, rate, dt=0.1, densities=(), **options):
    which = name if isinstance(name, FilterChoice) else choose_filter(name)
    return filter_at_rate(which, options, tuned(values, dt), rate, densities)


def numbers(found):
    return {q.name: q.value for q in found.tuned.quantities}


def van_loan(A, W, dt):
    """F and Q of a sample, by one exponential of the matrix of twice the size."""
    n = len(A)
    found = expm(dt * np.block([[-A, W], [np.zeros((n, n)), A.T]]))
    F = found[n:, n:].T
    return F, F @ found[:n, n:]


def steady(F, Q, R):
    H = np.eye(1, len(F))
    P = solve_discrete_are(F.T, H.T, Q, np.array([[R]]))
    return (P @ H.T / (P[0, 0] + R)).ravel()


@pytest.mark.parametrize("rate", RATES)
def test_a_level_keeps_its_density(rate):
    q, R = 0.3, 2.0
    found = at(
        "local-level", {"q": (q, "Pa^2/s"), "R": (R, "Pa^2"), "Q_derived": (q * 0.1, "Pa^2")}, rate
    )
    values, ratio = numbers(found), q / rate / R
    assert values["q"] == q
    assert values["R"] == R
    assert found.tuned.dt == pytest.approx(1 / rate)
    assert values["Q_derived"] == pytest.approx(q / rate, rel=1e-14)
    # K^2 / (1 - K) = Q / R
    assert values["K"] == pytest.approx((np.sqrt(ratio**2 + 4 * ratio) - ratio) / 2, rel=1e-9)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize(("name", "n"), [("constant-velocity", 2), ("constant-acceleration", 3)])
def test_trackers_gains_are_those_of_the_riccati_equation(name, n, rate):
    q, R = 0.7, 4.0
    W = np.zeros((n, n))
    W[-1, -1] = q
    F, Q = van_loan(np.eye(n, k=1), W, 1 / rate)
    K = steady(F, Q, R)
    values = numbers(at(name, {"q": (q, "m^2/s^3"), "R": (R, "m^2")}, rate))
    np.testing.assert_allclose(values["Q_derived"], Q, rtol=1e-10)
    np.testing.assert_allclose(values["K"], K, rtol=1e-6)  # scipy's, at gains of 1e-3
    np.testing.assert_allclose(values["L"], F @ values["K"], rtol=1e-12)
    T = 1 / rate
    assert values["alpha"] == pytest.approx(values["K"][0], rel=1e-14)
    assert values["beta"] == pytest.approx(values["K"][1] * T, rel=1e-14)
    if n == 3:
        assert values["gamma"] == pytest.approx(values["K"][2] * 2 * T**2, rel=1e-14)


@pytest.mark.parametrize("rate", RATES)
def test_the_vertical_channel_has_its_gains_of_both_kinds(rate):
    q, bias, R, T = 0.01, 1e-4, 0.1, 1 / rate
    given = {
        "q_acc": (q, "m^2/s^3"),
        "q_bias": (bias, "m^2/s^5"),
        "R_baro": (R, "m^2"),
        "climb0": (1.0, "m/s"),
        "bias0": (1.0, "m/s^2"),
    }
    values = numbers(at("vertical", given, rate))
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]])
    F, Q = van_loan(A, np.diag([0.0, q, bias]), T)
    np.testing.assert_allclose(values["Q"], Q, rtol=1e-9, atol=1e-14 * Q.max())
    np.testing.assert_allclose(values["K"], steady(F, Q, R), rtol=1e-6)
    np.testing.assert_allclose(values["L"], F @ values["K"], rtol=1e-12)
    assert "alpha" not in values  # the third state is an offset


def test_a_variance_stays_or_grows_as_is_asked():
    values = {"q": (0.3, "Pa^2/s"), "R": (2.0, "Pa^2")}
    stays = at("local-level", values, 40.0)
    assert stays.notes == (
        "R stays 2, the variance of one measurement; if the sensor averages between samples it "
        "grows with the rate, to 8: --density R",
    )
    grown = at("local-level", values, 40.0, densities=("R",))
    assert numbers(grown)["R"] == pytest.approx(8.0)
    assert grown.notes == ("R is 8: a density times the rate, as was asked for",)
    # Then the smoothing is the same in seconds, as nearly as samples allow: K rate = sqrt(q / N^2).
    K = [
        float(numbers(at("local-level", values, rate, densities=("R",)))["K"]) * rate
        for rate in (1e5, 1e6)
    ]
    np.testing.assert_allclose(K, np.sqrt(0.3 / 0.2), rtol=1e-2)
    assert at("local-level", values, 10.0).notes == ()
    with pytest.raises(ValueError, match="^unknown variance of a sample 'q'; "):
        at("local-level", values, 40.0, densities=("q",))


def test_filters_without_a_linear_model_keep_what_they_have():
    values = {"tau": (0.5, "s"), "angle0": (0.0, "rad")}
    assert numbers(at("complementary", values, 60.0)) == {"tau": 0.5, "angle0": 0.0}


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        (
            "alpha-beta",
            {"alpha": (0.5, ""), "beta": (0.2, "")},
            "alpha and beta of alpha-beta hold only for samples at 10 Hz; "
            "tune constant-velocity, whose density holds at every rate",
        ),
        (
            "alpha-beta-gamma",
            {"alpha": (0.5, ""), "beta": (0.2, ""), "gamma": (0.1, "")},
            "alpha and beta and gamma of alpha-beta-gamma hold only for samples at 10 Hz; "
            "tune constant-acceleration, whose density holds at every rate",
        ),
    ],
)
def test_gains_of_one_sample_time_are_refused(name, values, words):
    with pytest.raises(ValueError, match=f"^{words}$"):
        at(name, values, 60.0)


class Numbers(NamedTuple):
    q: Annotated[Array, Param("m^2/s", "of the walk", 1.0, 1e-6, 1e6)]
    R: Annotated[Array, Param("m^2", "of a measurement", 1.0, 1e-6, 1e6)]


class Seen(NamedTuple):
    z: Annotated[Array, Channel("m", "measured")]


@dataclass(frozen=True)
class Own:
    """A Gauss-Markov process of one second, a class of a user's own."""

    dt: float
    per_sample: bool = False
    params, inputs, outputs = Numbers, Seen, {"x": Channel("m", "estimated")}

    def init(self, params):
        return jnp.zeros(())

    def step(self, params, state, inputs):
        return state, state

    def linear(self, params):
        F = jnp.reshape(jnp.exp(-jnp.asarray(self.dt)), (1, 1))
        Q = params.q * (0.1 if self.per_sample else (1 - jnp.exp(-2 * jnp.asarray(self.dt))) / 2)
        one = jnp.eye(1)
        return LinearForm(Transition(F, one, jnp.reshape(Q, (1, 1))), one, jnp.ones(1) * params.R)

    def measured(self, inputs):
        return Measured(np.asarray(inputs.z)[:, None])


@dataclass(frozen=True)
class Bare:
    dt: float
    params, inputs, outputs = Numbers, Seen, {"x": Channel("m", "estimated")}

    def init(self, params):
        return jnp.zeros(())

    def step(self, params, state, inputs):
        return state, state


@dataclass(frozen=True)
class Timeless:
    params, inputs, outputs = Numbers, Seen, {"x": Channel("m", "estimated")}
    init, step = Bare.init, Bare.step


NOISE = {"q": (0.3, "m^2/s"), "R": (2.0, "m^2")}


@pytest.mark.parametrize("rate", RATES)
def test_an_own_class_has_it_from_its_linear_model(rate):
    values = numbers(at(choose_filter(Own), NOISE, rate))
    F, Q = van_loan(np.array([[-1.0]]), np.array([[0.3]]), 1 / rate)
    assert values["Q_derived"].item() == pytest.approx(Q.item(), rel=1e-9)
    assert values["K"].item() == pytest.approx(steady(F, Q, 2.0).item(), rel=1e-6)
    assert values["L"].item() == pytest.approx(F.item() * values["K"].item(), rel=1e-12)


@pytest.mark.parametrize(
    ("cls", "options", "words"),
    [
        (Own, {"per_sample": True}, "the process noise of Own does not depend on dt"),
        (Bare, {}, "Bare has no method linear, so its numbers hold only for"),
        (Timeless, {}, "Timeless has no sample time, so its numbers hold only at their own rate"),
    ],
)
def test_what_holds_for_its_own_rate_alone_is_refused(cls, options, words):
    with pytest.raises(ValueError, match=f"^{words}"):
        at(choose_filter(cls), NOISE, 60.0, **options)


MODEL = {
    "parameters": ["q", "R"],
    "states": ["x", "v"],
    "measurements": ["z"],
    "model": {"A": [[0, 1], [0, 0]], "G": [0, 1], "Q": "q", "C": [1, 0], "R": "R"},
}
STEPS = {"F": [[1, "dt"], [0, 1]], "G": [0, 1], "C": [1, 0], "R": "R"}


@pytest.mark.parametrize("rate", RATES)
def test_a_continuous_model_of_a_text_file(rate):
    found = at(choose_filter(MODEL), {"q": (0.3, ""), "R": (2.0, "")}, rate)
    values = numbers(found)
    F, Q = van_loan(np.eye(2, k=1), np.diag([0.0, 0.3]), 1 / rate)
    K = steady(F, Q, 2.0)
    np.testing.assert_allclose(values["Q_derived"], Q, rtol=1e-10)
    np.testing.assert_allclose(values["K"].ravel(), K, rtol=1e-6)
    np.testing.assert_allclose(values["L"].ravel(), F @ values["K"].ravel(), rtol=1e-12)
    assert values["beta"] == pytest.approx(values["K"][1].item() / rate, rel=1e-12)
    told = {f.name: f.value for f in found.findings}
    assert told["q.density"] == 0.3
    assert told["q.variance"] == pytest.approx(0.3 / rate)


def test_a_discrete_model_of_a_text_file_has_to_know_how_long_a_sample_is():
    given = {"q": (0.3, ""), "R": (2.0, "")}
    grows = MODEL | {"model": STEPS | {"Q": "q*dt"}}
    values = numbers(at(choose_filter(grows), given, 50.0))
    np.testing.assert_allclose(values["Q_derived"], [[0, 0], [0, 0.3 / 50]], rtol=1e-12)
    stays = MODEL | {"model": STEPS | {"Q": "q"}}
    with pytest.raises(ValueError, match="give a density times dt, or a continuous model"):
        at(choose_filter(stays), given, 50.0)


# --- the command line --------------------------------------------------------------------------


@pytest.fixture
def run(cli, here):
    log = cases.write(here / "track.csv", cases.track(samples=120))
    code, _, err = cli(
        *("fit", log, "--filter", "constant-velocity", "--map", "x=x:m", "--map", "y=y:m"),
        *("--fix", "q=0.5", "--no-hold-out", "--starts", 1, "--out", "run"),
    )
    assert code == 0, err
    return here / "run"


def test_export_at_a_rate(cli, run):
    code, out, err = cli("export", run, "--rate", 60)
    assert code == 0, err
    assert out.splitlines()[0].startswith("Noise")
    assert "alpha" in out
    assert err.startswith("R stays ")
    code, out, err = cli("export", run, "--rate", 60, "--to", "json", "-o", "-")
    assert code == 0, err
    document = json.loads(out)
    assert document["dt"] == pytest.approx(1 / 60)
    found = {q["name"]: q["value"] for q in document["quantities"]}
    F, Q = van_loan(np.eye(2, k=1), np.diag([0.0, 0.5]), 1 / 60)
    np.testing.assert_allclose(found["K"], steady(F, Q, found["R"]), rtol=1e-7)
    code, _, err = cli("export", run, "--rate", 60, "--to", "c")
    assert code == 0
    assert "wrote constant_velocity_60hz.h" in err


def test_a_fit_tells_its_noise_and_gains(run):
    result = json.loads((run / "result.json").read_text())
    told = {f["name"]: (f["value"], f["unit"]) for f in result["findings"]}
    assert told["q.density"] == (0.5, "m^2/s^3")
    assert told["q.variance"] == (pytest.approx(0.25), "m^2/s^2")
    assert told["q.deviation"] == (pytest.approx(0.5), "m/s")
    R = told["R.variance"][0]
    assert 3 < R < 5
    assert told["R.variance"][1] == "m^2"
    assert told["R.density"] == (pytest.approx(R / 2), "m^2/Hz")
    assert told["R.deviation"] == (pytest.approx(R**0.5), "m")
    assert told["Q22"] == (pytest.approx(0.25), "m^2/s^2")
    assert told["L1"][0] == pytest.approx(told["K1"][0] + 0.5 * told["K2"][0])
    assert told["alpha"][0] == told["K1"][0]
    assert told["beta"][0] == pytest.approx(0.5 * told["K2"][0])
    assert told["K2"][1] == "1/s"


REFUSED = (
    ((), "|ardupilot, or --rate HZ"),
    (("--to", "c", "--density", "R"), "--density needs --rate"),
    (("--rate", "-1"), "--rate is -1; give a positive number of samples a second"),
    (("--rate", "60", "--density", "S"), "unknown variance of a sample 'S'"),
    (("--rate", "60", "--to", "pdf"), "unknown format 'pdf'"),
)


def test_refusals(cli, run):
    for arguments, words in REFUSED:
        code, out, err = cli("export", run, *arguments)
        assert code == 2
        assert not out
        assert words in err.splitlines()[-1]
    assert not list(run.parent.glob("constant_velocity*"))
