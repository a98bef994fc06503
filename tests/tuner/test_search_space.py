"""Where a fit begins and looks: from the data, in any unit, and what can be known before it."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, ClassVar, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

import tuner
from benchmarks.units import Scaled, fitted, of_any_unit
from filters import (
    Channel,
    LevelSample,
    LinearForm,
    LocalLevel,
    Measured,
    Param,
    Transition,
)
from objectives import Data, InnovationLikelihood
from tests.tuner import fit_cases as cases
from tuner import Positive, Problem, Space
from tuner.catalogue import find
from tuner.run.fit import pose_on
from tuner.run.search_space import Wishes
from tuner.solvers.gradient import minimise

NILE = Path(__file__).resolve().parents[3] / "shared" / "data" / "tuning_benchmarks" / "nile.csv"


def parameters(filter, channels, rate=1.0, units=None, **wishes):
    record = tuner.Record.of(channels, rate_hz=rate, units=units)
    cls = find("tuner.filters", filter)
    posed = pose_on(filter, cls, (record,), Wishes(**wishes))
    return dict(posed.problem.space.parameters)


def of_level(z, **wishes):
    return parameters("local-level", {"z": z}, **wishes)


def test_the_box_holds_what_the_data_say():
    """A walk too quiet to be seen, and a smooth course of 10^7 times its noise."""
    draw = np.random.default_rng(2)
    quiet = np.cumsum(1e-6 * draw.normal(size=3000)) + draw.normal(size=3000)
    q, R = (of_level(quiet)[name] for name in ("q", "R"))
    assert R.low < 1.0 < R.high
    assert q.low < 1e-2 / 3000**2 < q.high  # N samples of noise 1 show a q of about 1/N^2
    t = np.arange(400.0)
    smooth = 1e4 * np.sin(t / 40) + 1e-3 * draw.normal(size=400)
    R = parameters("constant-velocity", {"x": smooth})["R"]
    assert R.low < 1e-6 < R.high


def test_the_default_is_not_moved_by_outliers():
    z = cases.level()["z"]
    wild = z.copy()
    wild[::40] += 1e6
    one, other = (of_level(each)["R"].init for each in (z, wild))
    assert other == pytest.approx(one, rel=0.2)


@pytest.mark.parametrize("z", [np.zeros(50), np.full(50, 3.0), np.repeat([1.0, 2.0], 25)])
def test_a_record_without_noise_has_a_box(z):
    for parameter in of_level(z).values():
        assert 0 < parameter.low < parameter.init < parameter.high < np.inf


def test_wishes_come_first():
    z = cases.level()["z"]
    space = of_level(z, start={"q": 1e13}, bound={"R": (0.5, 2.0)})
    assert (space["q"].init, space["q"].high) == (1e13, 1e13)
    assert (space["R"].low, space["R"].high) == (0.5, 2.0)


def test_what_a_fit_knows_stays_where_the_data_do_not_contradict():
    data = cases.climb(samples=300)
    units = {"acc": "m/s^2", "baro": "m"}

    def posed(factor):
        channels = {"acc": data["acc"], "baro": factor * data["baro"]}
        return parameters("vertical", channels, 50.0, units)

    plain = posed(1.0)
    assert plain["R_baro"].init == 0.1  # typical
    assert plain["q_bias"].low == 1e-12
    wild = posed(1e6)  # noise of 10^5 m or more
    assert wild["R_baro"].init > 1e8
    assert wild["R_baro"].high > 1e9


@pytest.mark.parametrize(
    ("name", "scaled"),
    [
        ("local-level", Scaled(size=1e-9)),
        ("local-level", Scaled(size=1e9)),
        ("constant-velocity", Scaled(size=1e9, clock=1e-9)),
        ("constant-velocity", Scaled(size=1e-9, clock=1e9)),
    ],
)
def test_a_fit_is_the_same_in_any_unit(name, scaled, plain):
    """All filters and more factors: ``python -m benchmarks.units``."""
    other = fitted(name, scaled, starts=2)
    assert set(other) == {"q", "R"}
    assert other == pytest.approx(plain(name), rel=1e-6)


@pytest.fixture(scope="module")
def plain():
    found = {}

    def of(name):
        if name not in found:
            found[name] = fitted(name, Scaled(), starts=2)
        return found[name]

    return of


def test_the_battery_of_units_has_all_filters_of_any_unit():
    assert {"local-level", "constant-velocity", "constant-acceleration", "alpha-beta"} <= {
        *of_any_unit()
    }


@pytest.mark.skipif(not NILE.exists(), reason=f"there is no {NILE}")
def test_the_nile_from_everywhere():
    """R 15099 and q 1469.1 (Durbin and Koopman, 2012, 2.2.5) from 25 starts over 12 decades."""
    z = np.loadtxt(NILE, delimiter=",", skiprows=1)[:, 1]
    space = Space.of(q=Positive(1.0, 1e-6, 1e12), R=Positive(1.0, 1e-6, 1e12))
    data = Data(LevelSample(z), np.zeros(len(z)))
    problem = Problem("nile", space, LocalLevel(1.0), None, InnovationLikelihood(), data)
    for decades in product(np.linspace(-2.0, 10.0, 5), repeat=2):
        start = np.log(10.0) * np.array(decades)
        limits = {"gtol": 1e-8, "maxiter": 200}
        end = minimise(problem, start, "l-bfgs-b", limits, space.box())
        assert np.exp(end.z) == pytest.approx([1469.1, 15099.0], rel=1e-4), decades


class Whites(NamedTuple):
    q: Annotated[Array, Param("unit^2", "variance of a quantity", 1.0, 1e-10, 1e10)]
    R: Annotated[Array, Param("unit^2", "variance of its measurement", 1.0, 1e-10, 1e10)]


class Seen(NamedTuple):
    z: Annotated[Array, Channel("unit", "measurement")]


class Found(NamedTuple):
    x: Annotated[Array, Channel("unit", "estimate")]
    innovation: Annotated[Array, Channel("unit", "of it", kind="detail")]
    variance: Annotated[Array, Channel("unit^2", "of the innovation", kind="detail")]


@dataclass(frozen=True)
class WhiteInWhite:
    """A quantity that is new with every sample, and measured with noise: which is which?"""

    dt: float
    params, inputs, outputs = Whites, Seen, Found
    states: ClassVar = {"x": Channel("unit", "estimate")}

    def init(self, params):
        return jnp.zeros(())

    def step(self, params, state, inputs):
        s = params.q + params.R
        seen = ~jnp.isnan(inputs.z)
        y = jnp.where(seen, inputs.z, 0.0)
        x = params.q / s * y
        return state, Found(x, y[None], jnp.where(seen, s, 0.0)[None])

    def linear(self, params):
        one = jnp.ones((1, 1))
        step = Transition(0 * one, one, params.q * one)
        return LinearForm(step, one, params.R[None])

    def measured(self, inputs):
        return Measured(np.asarray(inputs.z)[:, None])


def test_what_cannot_be_told_apart_is_said_before_anything_is_fitted():
    z = np.random.default_rng(1).normal(size=200)
    record = tuner.Record.of({"z": z}, rate_hz=1.0)
    posed = pose_on("whites", WhiteInWhite, (record,), Wishes())
    assert posed.notes[-1] == (
        "q and R cannot be told apart by what is measured: only q + R is determined; fix one, "
        "--fix R=VALUE"
    )
    held = pose_on("whites", WhiteInWhite, (record,), Wishes(fix={"R": 0.3}))
    assert not any("told apart" in note for note in held.notes)
    # And it stands in the fit's own words.
    fit = tuner.fit(WhiteInWhite, record, starts=1, hold_out=False)
    use, *_, still, _ = fit.summary().split("\n")
    assert use.count("(not determined)") == 2
    assert still.startswith("open      q and R cannot be told apart")


def test_a_record_of_two_samples_is_said_to_be_too_short():
    record = tuner.Record.of({"z": np.array([1.0, 2.0])}, rate_hz=1.0)
    posed = pose_on("local-level", LocalLevel, (record,), Wishes())
    assert "q and R cannot be told apart by what is measured: only q + 2 R" in posed.notes[-1]
