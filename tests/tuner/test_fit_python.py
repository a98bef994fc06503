"""tuner.fit: what it returns, and what it refuses, from Python."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest

import tuner
from filters import Channel, LocalLevel, Param
from tests.tuner import fit_cases as cases

ONCE = {"starts": 1, "hold_out": False}
WORDS = ["use", "how good", "trust", "open", "next"]


def record(z, **more):
    return tuner.Record.of({"z": z}, rate_hz=1.0, **more)


@pytest.fixture(scope="module")
def level():
    return cases.level()


@pytest.fixture(scope="module")
def fit(level):
    return tuner.fit("local-level", record(level["z"], units={"z": "m"}), starts=2)


def test_what_a_fit_holds(fit, level):
    q, R = (float(fit.solution.parameters[name].value) for name in ("q", "R"))
    assert (float(fit.params.q), float(fit.params.R)) == (q, R)
    assert fit.outputs.level.shape == (400,)
    assert fit.outputs is fit.outputs
    y, s = cases.level_loop(level["z"], q, R, 1.0)
    # 1e-12 of numbers near 1, summed 400 times.
    np.testing.assert_allclose(fit.outputs.innovation[1:, 0], y, atol=1e-12)
    np.testing.assert_allclose(fit.outputs.variance[1:, 0], s, rtol=1e-12)
    assert fit.judged.tuned == pytest.approx(cases.deviation(y, s), rel=1e-12)
    assert fit.solution.derived == pytest.approx({"Q": q, "K": fit.solution.derived["K"]})
    # The steady gain: K^2 / (1 - K) = Q / R.
    K = fit.solution.derived["K"]
    assert pytest.approx(q / R, rel=1e-9) == K**2 / (1 - K)


def test_the_summary(fit):
    lines = fit.summary().splitlines()
    assert [line[:10].strip() for line in lines] == WORDS
    assert str(fit) == fit.summary()
    assert "RUN" not in lines[-1]  # there is no run's folder
    assert " m^2/s" in lines[0]


def test_diagnostics_are_those_of_a_loop(fit, level):
    for values, found in zip(
        (fit.posed.problem.parameters(fit.posed.problem.space.start()), fit.params._asdict()),
        fit.judged.diagnostics,
        strict=True,
    ):
        y, s = cases.level_loop(level["z"], float(values["q"]), float(values["R"]), 1.0)
        e = y / np.sqrt(s)
        assert found.numbers == 399
        assert found.nis == pytest.approx(np.mean(e**2), rel=1e-9)
        # The moments' own correlation, without their means, as of numbers predicted to be 0.
        ends = (np.sum(e[1:] ** 2) + np.sum(e[:-1] ** 2)) / 2
        assert found.lag_one == pytest.approx(np.sum(e[1:] * e[:-1]) / ends, abs=1e-9)
        # Chi-square of 399 degrees over 399, fewer by what correlation takes: r^2 of the lags that
        # are beyond two deviations, until two in a row are not.
        from scipy.stats import chi2

        spread, quiet, lag = 1.0, 0, 0
        while quiet < 2:
            lag += 1
            square = (np.sum(e[lag:] * e[:-lag]) / np.sum(e * e)) ** 2
            spread, quiet = (spread + 2 * square, 0) if square >= 4 / 399 else (spread, quiet + 1)
        low, high = chi2.ppf([0.025, 0.975], 399 / spread) / (399 / spread)
        assert [found.low, found.high] == pytest.approx([low, high], rel=1e-9)
        assert [found.factor_low, found.factor_high] == pytest.approx(
            [found.nis / high, found.nis / low], rel=1e-9
        )
    assert fit.judged.diagnostics[1].verdict == "consistent"
    assert not fit.judged.diagnostics[1].failed


def test_a_search_without_wishes_reaches_the_optimum_of_another(fit, level):
    best, value = cases.tuned_by_hand(
        lambda q, R: cases.level_loop(level["z"], q, R, 1.0), [0.5, 2.0]
    )
    assert [float(fit.params.q), float(fit.params.R)] == pytest.approx(best, rel=1e-3)
    assert fit.judged.tuned == pytest.approx(value, rel=1e-9)


# A class of a user's own, and what is no such class.


class Share(NamedTuple):
    share: Annotated[jnp.ndarray, Param("", "of what is new", 0.5, 0.0, 1.0)]


@dataclass(frozen=True)
class Smooth:
    """Exponential smoothing without a variance and without a sample time."""

    params, outputs = Share, {"level": Channel("unit", "smoothed level")}
    inputs = {"z": Channel("unit", "measured level")}  # noqa: RUF012
    states = outputs

    def init(self, params):
        return jnp.zeros_like(params.share)

    def step(self, params, state, inputs):
        new = jnp.where(jnp.isnan(inputs), 0.0, inputs - state)
        level = state + params.share * new
        return level, level


def test_a_class_of_ones_own(level):
    found = tuner.fit(Smooth, record(level["z"], truth={"level": level["level"]}), **ONCE)
    share = float(found.params.share)

    def rms(a):
        x, errors = 0.0, []
        for z, true in zip(level["z"], level["level"], strict=True):
            x = x + a * (z - x)
            errors.append(x - true)
        return np.sqrt(np.mean(np.square(errors)))

    assert found.judged.tuned == pytest.approx(rms(share), rel=1e-12)
    assert min(rms(share - 0.02), rms(share + 0.02)) > rms(share)
    assert found.posed.problem.name == "Smooth"
    assert [line[:10].strip() for line in found.summary().splitlines()] == WORDS


def refused(what, *words, **options):
    with pytest.raises(ValueError, match=words[0]) as caught:
        tuner.fit(what, **options)
    told = str(caught.value)
    assert "\n" not in told
    for word in words:
        assert word in told


def test_what_is_no_filter(level):
    z = record(level["z"])
    refused("local-levle", "did you mean local-level", record=z)
    refused(int, "int declares no inputs", record=z)
    refused(LocalLevel(1.0), "no filter's name or class; give LocalLevel", record=z)
    refused(Smooth, "Smooth outputs no innovation and no variance", "--truth level", record=z)


def test_what_does_not_fit_a_filter(level):
    z = level["z"]
    refused("local-level", "needs a recording", record=[])
    refused("local-level", "unknown channel 'x'", record=tuner.Record.of({"x": z}, rate_hz=1.0))
    two = tuner.Record.of({"z": np.stack([z, z], axis=1)}, rate_hz=1.0)
    refused("local-level", "z has 2 parts, and the filter takes one number", record=two)
    flat = tuner.Record.of({"gyr": z, "acc": np.ones((400, 3))}, rate_hz=1.0)
    refused("madgwick", "gyr has one part, and the filter takes 3: x, y, z", record=flat)
    wrong = tuner.Record.of({"acc": z, "baro": z}, rate_hz=1.0, units={"baro": "Pa"})
    refused("vertical", "'baro'", "Pa", "m", record=wrong)
    far = record(z, truth={"level": np.stack([z, z], axis=1)})
    refused("local-level", "the truth of level has 2 parts", record=far)
    refused("local-level", "unknown output of local-level 'K'", record=record(z, truth={"K": z}))
    uneven = tuner.Record.of({"z": z}, times=np.cumsum(0.5 + np.arange(400) % 2))
    refused(Smooth, "Smooth has no sample time dt", record=uneven)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"start": {"q": np.nan}}, "the start of q is nan; give a finite number"),
        ({"fix": {"q": np.inf}}, "q, which is fixed, is inf; give a finite number"),
        ({"bound": {"q": (2.0, 1.0)}}, "the bound of q, 2 to 1, is no range that rises"),
        ({"bound": {"q": (1.0, np.inf)}}, "the bound of q, 1 to inf, is no range that rises"),
        ({"solver": "bfgs"}, "unknown solver 'bfgs'"),
        ({"starts": 0}, "needs at least one start"),
        ({"options": {"dt": 2.0}}, "unknown option of local-level 'dt'"),
    ],
)
def test_wishes_that_cannot_be(level, options, words):
    refused("local-level", words, record=record(level["z"]), **options)


def test_little_data_is_not_held_out(level):
    short = tuner.fit("local-level", record(level["z"][:40]), starts=1)
    assert short.judged.held_out is None
    assert "on the last" not in short.summary()
