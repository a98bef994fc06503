"""The study of Chauhan et al. 2009: its records, what is said of errors, and rows that can flip."""

from dataclasses import replace
from types import SimpleNamespace

import jax
import numpy as np
import pytest

from filters import Lanes
from filters.gps_aided import euler_angles
from studies.chauhan2009 import claims, plan, problems
from studies.chauhan2009.behaviour import Behaviour, behaviour
from studies.chauhan2009.data import BEFORE, Records, Step, records, times
from studies.chauhan2009.paper import DT, EVERY
from studies.chauhan2009.problems import (
    FUZZY,
    by_hand,
    estimated,
    parameters,
    random_scale,
    randomly,
)
from studies.chauhan2009.settings import Settings
from studies.chauhan2009.sweep import Case, Sweep, ranges
from studies.chauhan2009.windows import ByPeriod, by_period
from tests import oracles_chauhan2009 as oracle
from tuner.cli import invoke
from tuner.run.comparison import Verdict

PAIR = replace(FUZZY, samples=2)
QUICK = {"xla_backend_optimization_level": 0}
SHORT = Settings(
    seconds=180.0,
    records=3,
    train=1,
    held_out=1,
    windows=(4,),
    factors=(0.1, 1.0, 10.0),
    tuned_on=(35.1,),
)


@pytest.fixture(scope="module", autouse=True)
def quick():
    """Without the compiler's optimisation, which changes no formula and takes most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        function = problems._run.__wrapped__
        patch.setattr(problems, "_run", jax.jit(function, static_argnums=0, compiler_options=QUICK))
        yield


def record(step, seed, settings=SHORT):
    made = records(settings, [step], [seed])
    return made.inputs.gyr[:, 0], made.inputs.angles[:, 0], made.truth[:, 0]


def test_a_seen_step_is_in_the_gyroscopes_and_a_silent_one_is_not():
    quiet = SHORT.model_copy(update={"gyro_noise": 0.0, "bias": (0.0, 0.0, 0.0)})
    for motion, turned in (("seen", 17.4), ("silent", 0.0)):
        rate, _, truth = record(Step(17.4, motion), 0, quiet)
        np.testing.assert_allclose(np.degrees(rate.sum(axis=0) * DT), [0.0, turned, 0.0], atol=1e-9)
        assert np.degrees(truth[-1]) == pytest.approx(17.4)
        assert abs(truth[times(quiet) <= BEFORE]).max() == 0


def test_every_fourth_tick_has_a_measurement_of_the_noise_that_was_asked_for():
    long = SHORT.model_copy(update={"seconds": 3600.0})
    _, z, truth = record(Step(30.0, "seen"), 0, long)
    seen = ~np.isnan(np.asarray(z)).any(axis=1)
    assert np.flatnonzero(seen)[:3].tolist() == [3, 7, 11]
    assert seen.sum() == len(seen) // EVERY
    noise = np.degrees(np.asarray(z)[seen] - np.stack([0 * truth, truth, 0 * truth], 1)[seen])
    np.testing.assert_allclose(noise.std(axis=0), 1.0, rtol=0.07)  # 3600 draws: 4 deviations
    np.testing.assert_allclose(record(Step(30.0, "seen"), 1, long)[2], truth)
    assert not np.array_equal(
        record(Step(30.0, "seen"), 1, long)[0], record(Step(30.0, "seen"), 0, long)[0]
    )


@pytest.mark.parametrize("motion", ["seen", "silent"])
def test_angles_constructed_from_gps_are_those_of_one_update_ago(motion):
    """Without noise, and away from the step, in which the speed changes between positions."""
    exact = {"measured": "gps", "gps_noise": 0.0, "acc_noise": 0.0}
    _, z, truth = record(Step(28.2, motion), 0, SHORT.model_copy(update=exact))
    z, t = np.asarray(z), times(SHORT)
    assert np.isnan(z[:11]).all()
    seen = ~np.isnan(z).any(axis=1)
    assert np.flatnonzero(seen)[:2].tolist() == [11, 15]
    steady = seen & ((t < BEFORE) | (t > BEFORE + 6))
    before = np.concatenate([np.zeros(EVERY), truth])[: len(t)]
    wanted = np.stack([0 * t, before, 0 * t], axis=1)
    np.testing.assert_allclose(z[steady], wanted[steady], atol=1e-9)


def test_gps_noise_is_in_the_constructed_angles():
    noisy = SHORT.model_copy(update={"measured": "gps", "seconds": 600.0})
    z = np.asarray(record(Step(0.001, "silent"), 0, noisy)[1])[100:]
    z = z[~np.isnan(z).any(axis=1)]
    # The track over 2 s, 40 m, between positions with 0.1 m of noise each
    assert z[:, 2].std() == pytest.approx(np.sqrt(2) * 0.1 / 40, rel=0.15)


def test_what_is_said_of_errors():
    t = times(SHORT)
    truth = np.where(t > BEFORE, 0.2, 0.0)
    error = np.zeros(len(t))
    error[(t > 60) & (t <= 61)] = -0.1  # at t = 61 half the step
    error[t == 63.0] = 0.02  # 10 %, 3 s after it
    error[t == 125.0] = 0.011  # 5.5 %, later than 60 s
    error[(t > 120) & (np.arange(len(t)) % 8 == 3)] += 0.002
    pitch = np.stack([truth + error, truth], axis=1)
    made = Records(None, np.stack([truth, truth], axis=1))
    found = behaviour(pitch, made, SHORT, float(np.degrees(0.2)))
    np.testing.assert_allclose(found.peak, [50.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.settled, [65.0, 0.0])
    np.testing.assert_allclose(found.offset, [0.5 + 5.5 / 60, 0.0], atol=1e-9)
    late = 100 * error[3::4][t[3::4] > 120] / 0.2
    np.testing.assert_allclose(found.ripple, [late.std(), 0.0], atol=1e-9)


def test_both_laws_are_the_textbooks_on_a_record():
    """The random one with the scale the notes describe, from the fuzzy run on the same data."""
    made = records(SHORT, [Step(14.1, "silent")], [0, 1, 2])
    fuzzy = estimated(FUZZY, made.inputs, by_hand(SHORT))
    _, random = randomly(SHORT, made, np.asarray(fuzzy.Q), (1.0, 2.0), seed=5)
    draws = np.random.default_rng([5, 7]).uniform(size=(*made.truth.shape, 7))
    R = np.radians(SHORT.noise) ** 2 * np.eye(3)
    for i in range(2):
        rate, z = np.asarray(made.inputs.gyr)[:, i], np.asarray(made.inputs.angles)[:, i]
        wanted = oracle.run(rate, z, "fuzzy", R=R)
        np.testing.assert_allclose(fuzzy.x[:, i], wanted["x"], atol=1e-11)
        late = wanted["Q"][round(BEFORE / DT) :] / (DT * EVERY)
        scale = 2.0 * np.sqrt(3 * late.mean(axis=0))
        wanted = oracle.run(rate, z, "random", R=R, scale=scale, draws=draws[3::4, i])
        angles = jax.vmap(euler_angles)(wanted["x"][:, :4])
        np.testing.assert_allclose(random[:, i], angles, atol=1e-11)


@pytest.mark.parametrize("samples", [2, 4])
def test_a_window_that_comes_with_the_data_is_the_filter_with_that_window(samples):
    made = records(SHORT, [Step(14.1, "silent")], [0, 1])
    params = parameters({"angle": 1.0, "floor": 1e-9})
    own = problems._run(Lanes(replace(FUZZY, samples=samples), 2), params, made.inputs)
    data = by_period(made, replace(FUZZY, samples=samples))
    found = problems._run(Lanes(ByPeriod(FUZZY), 2), params, data.inputs)
    by_tick = np.moveaxis(np.asarray(found.angles), 2, 1).reshape(-1, 2, 3)[: len(made.truth)]
    np.testing.assert_allclose(by_tick, own.angles, rtol=0, atol=1e-12)


@pytest.mark.parametrize("own", [replace(PAIR, slope="edge"), problems.CONSTANT])
def test_a_law_that_comes_with_the_data_is_the_filter_with_that_law(own):
    made = records(SHORT, [Step(14.1, "silent")], [0, 1])
    params = parameters({"angle": 1.0, "floor": 1e-9, "h": 0.4})
    data = by_period(made, own)
    wanted, found = (
        np.asarray(problems._run(Lanes(filter, 2), params, data.inputs).angles)
        for filter in (ByPeriod(own), ByPeriod(PAIR, any_law=True))
    )
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)


def test_at_lambda_one_both_laws_have_one_mean():
    Q = np.abs(np.random.default_rng(0).normal(size=(50, 2, 7)))
    u = np.random.default_rng(1).uniform(size=(200_000, 1, 1))
    drawn = ((random_scale(Q, 1.0) * u) ** 2).mean(axis=0) * DT * EVERY
    np.testing.assert_allclose(drawn, Q.mean(axis=0), rtol=0.01)


def test_parameters_go_where_they_belong():
    params = parameters({"angle": 2.0, "quaternion": 1e-3, "bias": 1e-7, "floor": 1e-9})
    np.testing.assert_allclose(params.process.Q, [1e-3] * 4 + [1e-7] * 3)
    np.testing.assert_allclose(params.R, np.radians(2.0) ** 2)
    np.testing.assert_allclose(params.process.floor, 1e-9)
    np.testing.assert_array_equal(params.q0, [1.0, 0.0, 0.0, 0.0])


def test_ranges_in_words():
    factors = [0.01, 0.1, 1.0, 10.0]
    assert ranges([], factors) == "none"
    assert ranges(factors, factors) == "0.01 to 10"
    assert ranges([0.01, 1.0, 10.0], factors) == "0.01, 1 to 10"


# ------------------------------------------------------------------------------------------ rows


def said(peak, settled, ripple):
    return Behaviour(*(np.full(3, float(v)) for v in (peak, settled, ripple, 0.0)))


@pytest.mark.parametrize(("better", "verdict"), [(True, Verdict.HOLDS), (False, Verdict.FAILS)])
def test_claims_about_the_driving_noise_can_hold_and_fail(better, verdict):
    fuzzy, random = said(9, 1, 1), said(5, 2, 2)
    worse = said(10, 0.5, 0.5)
    sweep = Sweep(SHORT, 0)
    cases = (
        Case(Step(14.1, "silent"), None, fuzzy, (random, random if better else worse, random)),
    )
    sweep.__dict__["cases"] = cases  # where cached_property keeps them
    found = (
        claims.faster_settling(sweep, {}),
        claims.larger_overshoot(sweep, {}),
        claims.smaller_steady(sweep, {}),
    )
    for row in found:
        assert row.verdict is verdict
        assert row.ours == pytest.approx(1.0 if better else 2 / 3)
        assert ("0.1 to 10" if better else "0.1, 10") in row.note


def test_rows_that_need_no_tuning():
    sweep = Sweep(SHORT, 0)
    assert claims.textbook_regression(sweep, {}).verdict is Verdict.MATCH
    printed = claims.printed_rate(sweep, {})
    assert printed.verdict is Verdict.INCONSISTENT
    assert f"{printed.ours:.1f}" == oracle.PRINTED_TURN
    floorless = claims.positive_definite(sweep, {})
    assert (floorless.verdict, floorless.ours) == (Verdict.FAILS, 0.0)


def test_the_steady_error_is_the_same_in_degrees():
    row = claims.steady_deviation(Sweep(SHORT, 0), {})
    assert row.verdict is Verdict.FAILS
    assert row.ours == pytest.approx(1.0, abs=0.1)
    assert claims.tracking_error(Sweep(SHORT, 0), {}).verdict is Verdict.FAILS


@pytest.mark.parametrize(("angle", "verdict"), [(0.6, Verdict.HOLDS), (50.0, Verdict.FAILS)])
def test_fuzzy_and_constant_noise_are_judged_on_other_records(angle, verdict):
    """By hand: a constant Q that does not follow a silent step, and fuzzy ones that do, or not."""
    values = {
        "constant": {"quaternion": 1e-7, "bias": 1e-12, "angle": SHORT.noise},
        "fuzzy_4": {"angle": angle, "floor": 1e-12},
        "edge": {"angle": 90.0, "floor": 1e-12, "h": 0.1},
    }
    solutions = {
        (name, "x"): SimpleNamespace(
            value=float(name == "edge"),
            status=SimpleNamespace(trusted=True),
            parameters={key: SimpleNamespace(value=value) for key, value in given.items()},
        )
        for name, given in values.items()
    }
    row = claims.fuzzy_or_constant(Sweep(SHORT, 0), solutions)
    assert row.verdict is verdict
    assert "pitch error of fuzzy_4" in row.note


def test_all_laws_are_tuned_on_the_same_records():
    asked = plan(SHORT, (), 3, "")
    posed = {task.problem.name: task.problem for task in asked.tasks}
    assert list(posed) == ["constant", "fuzzy_4", "edge"]
    first = posed["constant"].data
    for problem in posed.values():
        np.testing.assert_array_equal(problem.data.truth, first.truth)
        assert problem.source == asked.source
    assert len({task.solver.starts for task in asked.tasks}) == 1
    assert asked.exports == ("constant", "fuzzy_4")


def test_a_claim_asks_for_what_it_needs_alone():
    asked = plan(SHORT, (), 3, "")
    assert asked.only(["fuzzy.*", "lp.textbook"]).tasks == ()
    assert len(asked.only(["fuzzy_vs_tuned_fixed_Q_heldout"]).tasks) == len(asked.tasks)


@pytest.mark.parametrize(
    ("setting", "what"),
    [
        ("seconds=10", "seconds"),
        ("windows=[5]", "an even number"),
        ("windows=[]", "windows"),
        ("noise=0", "noise"),
        ("tuned_on=[]", "tuned_on"),
        ("tuned_on=[90]", "tuned_on"),
        ("factors=[1.0]", "factors"),
    ],
)
def test_refused(setting, what, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    assert invoke(["run", "chauhan2009", "--set", setting]) == 2
    assert what in capfd.readouterr().err
