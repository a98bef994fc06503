"""What no data and no covariance can be, told as a problem is made."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filters import GyroscopeFilter, KownackiNoise, LevelSample, LocalLevel
from objectives import Data, InnovationLikelihood, StepResponse, Welch
from tests.strategies import covariance, seeds
from tuner.data.logs.clock import judged
from tuner.problem.parameters import Fixed, Positive
from tuner.problem.physics import _fault, check_leaf
from tuner.problem.problem import Problem
from tuner.problem.space import Space

N, DT = 401, 0.01
NOISE = 0.3 * np.random.default_rng(7).standard_normal(N)
ONES = ((1.0, 1.0), (1.0, 1.0))


def noise(v):
    return KownackiNoise(v["R"], v["Q"], v["P0"])


def gyro(R=0.09, P0=ONES, record=NOISE):
    objective = StepResponse(DT, Welch.matlab(N))
    step = np.where(np.arange(N) < N // 2, 0.0, 5.0)
    space = Space.of(R=Fixed(R), Q=Positive(0.1, 1e-6, 1e6), P0=Fixed(P0))
    data = Data(np.stack([step, record], 1), objective.truth(step))
    return Problem("g", space, GyroscopeFilter(DT, shape=(2,)), noise, objective, data)


REFUSED = {
    "R = -1": ({"R": -1.0}, "the R of g holds the variance -1; give"),
    "R infinite": ({"R": np.inf}, "the R of g holds inf; give a finite number"),
    "R no number": ({"R": np.nan}, "the R of g holds nan; give a finite number"),
    "P0 = -I": ({"P0": ((-1.0, 0.0), (0.0, -1.0))}, "the P0 of g holds the variance -1"),
    "P0 indefinite": ({"P0": ((1.0, 2.0), (2.0, 1.0))}, "has the eigenvalue -1, and"),
    "P0 lopsided": ({"P0": ((1.0, 0.5), (0.0, 1.0))}, "the P0 of g is not symmetric"),
    "all missing": ({"record": np.full(N, np.nan)}, f"an input of g is missing in all {N} samples"),
    "outlier": (
        {"record": np.where(np.arange(N) == 100, 1e12, NOISE)},
        "data.inputs is 1e+12 at (100, 1), where numbers are",
    ),
    "two outliers": (
        {"record": np.where(np.arange(N) % 300 == 100, -1e12, NOISE)},
        "data.inputs is -1e+12 at (100, 1)",
    ),
    "complex": ({"record": NOISE + 1j}, "data.inputs is complex, and samples are real numbers"),
    "text": ({"record": np.array(["a"] * N)}, "data.inputs is <U32, and samples are"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be(what):
    changed, sentence = REFUSED[what]
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        gyro(**changed)
    told = str(caught.value)
    assert sentence in told
    assert "\n" not in told
    assert ";" in told  # the way out


def test_what_can_be():
    holes = np.where(np.arange(N) % 3 == 0, np.nan, NOISE)
    assert gyro(P0=((0.0, 0.0), (0.0, 0.0)), record=holes)
    assert gyro(P0=((1.0, -1.0), (-1.0, 1.0)), record=1e6 * NOISE)


def test_variances_of_filters_that_say_so():
    def level(v):
        return LocalLevel.params(v["q"], v["R"])

    space = Space.of(q=Positive(1.0, 1e-3, 1e3), R=Fixed(-2.0))
    data = Data(LevelSample(jnp.asarray(NOISE)), np.zeros(N))
    with pytest.raises(ValueError, match=r"the R of level holds the variance -2"):
        Problem("level", space, LocalLevel(dt=DT), level, InnovationLikelihood(), data)
    spared = Data(LevelSample(jnp.asarray(NOISE), jnp.full(N, jnp.nan)), np.zeros(N))
    free = Space.of(q=Positive(1.0, 1e-3, 1e3), R=Positive(2.0, 1e-3, 1e3))
    assert Problem("level", free, LocalLevel(dt=DT), level, InnovationLikelihood(), spared)
    gone = Data(LevelSample(jnp.full(N, jnp.nan)), np.zeros(N))
    good = Space.of(q=Positive(1.0, 1e-3, 1e3), R=Fixed(2.0))
    with pytest.raises(ValueError, match=r"the input z of level is missing in all 401 samples"):
        Problem("level", good, LocalLevel(dt=DT), level, InnovationLikelihood(), gone)


@given(seeds(), st.integers(1, 5), st.integers(0, 5), st.floats(1e-12, 1e12))
def test_covariances_of_any_rank_and_size_are_covariances(rng, n, rank, scale):
    assert _fault(scale * covariance(rng, n, rank)) == ""
    assert _fault(scale * (covariance(rng, n, n) - 100.0 * np.eye(n))) != ""


@given(seeds(), st.floats(1e-9, 1e9), st.sampled_from(["noise", "pulses", "decay", "steps"]))
def test_natural_records_hold_no_outliers(rng, scale, kind):
    records = {
        "noise": rng.standard_t(2, 999),
        "pulses": np.where(np.arange(999) % 500 == 0, 1.0, 0.0),
        "decay": np.exp(-np.arange(999.0) / 3),
        "steps": np.repeat([0.0, 1e-6, 1.0], 333),
    }
    check_leaf("data", scale * records[kind])


@pytest.mark.parametrize(
    ("steps", "rate"), [((0.005, 0.015), 100.0), ((0.01, 0.011), 95.2), ((0.01, 0.02), 66.7)]
)
def test_steps_that_take_turns_fit_no_single_one(steps, rate):
    """Of steps in turn the middle one is no step of the record: it would be too short or long."""
    times = np.cumsum(np.resize(steps, 2000))
    clock = judged(times)
    assert clock.rate_hz == pytest.approx(rate, rel=1e-3)
    assert clock.even == (steps == (0.01, 0.011))
    assert clock.step * 1999 == pytest.approx(times[-1] - times[0], rel=1e-3)


def test_steps_in_turn_are_told(cli, here):
    times = np.cumsum(np.resize([0.005, 0.015], 2000))
    rows = [f"{t:.3f},{k * k % 17}" for k, t in enumerate(times)]
    (here / "log.csv").write_text("\n".join(["t,gx", *rows, ""]))
    _, out, _ = cli("columns", "log.csv")
    assert "uneven" in out
    assert "99.97" in out
