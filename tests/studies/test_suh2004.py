"""The study of Suh, Park, Kang and Ro 2004: its signals, and the rows that need no tuning."""

import json
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from filters.tilt_euler import TO_PAPER
from studies.suh2004 import problems
from studies.suh2004.bench import bench
from studies.suh2004.claims import CLAIMS
from studies.suh2004.data import Recordings, experiment_1, experiment_2, recordings
from studies.suh2004.paper import HEURISTIC
from studies.suh2004.problems import held_out
from studies.suh2004.settings import Settings
from tests import oracles_suh2004 as oracle
from tuner.certificate.intervals import estimates
from tuner.certificate.yardstick import yardstick
from tuner.cli import invoke
from tuner.problem import problem as engine
from tuner.run.comparison import Verdict
from tuner.solvers import Gradient
from tuner.stored_programs import StoredProgram

SHORT = Settings(seconds=20.0, train=1, held_out=1)
QUICK = {"xla_backend_optimization_level": 0}


@pytest.fixture(scope="module", autouse=True)
def quick():
    """Without the compiler's optimisation, which changes no formula and takes most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        for module, name in [(problems, "run_filter"), (engine, "value_of")]:
            function = getattr(module, name).__wrapped__
            patch.setattr(module, name, StoredProgram(function, 1, QUICK))
        yield


def printed(digits):
    """A number of so many digits, within half of its last one."""
    places = len(digits.partition(".")[2])
    return pytest.approx(float(digits), abs=0.5000001 * 10**-places)


@cache
def rows():
    made = bench(SHORT, 0)
    untuned = [claim for claim in CLAIMS if not claim.needs]
    return {row.quantity: row for claim in untuned for row in claim.compare(made, {})}


@cache
def paper(law, **settings):
    """S and M, (theta, phi) each, of the textbook loop on Experiment 2."""
    found = oracle.run(*oracle.experiment2(), law, **settings)
    return oracle.errors(found["theta"], found["phi"])


# ------------------------------------------------------------------------------------- signals


@pytest.mark.parametrize("unit", ["deg/s", "rad/s"])
def test_experiment_2_is_the_textbooks(unit):
    inputs = experiment_2(unit)
    acceleration, rate = oracle.experiment2(unit.partition("/")[0])
    # The same products in the same order: the sines' arguments reach 3.5e5, whose last bit alone
    # would be 6e-11 of the noise.
    np.testing.assert_allclose(inputs.acc, acceleration, rtol=0, atol=1e-15)
    np.testing.assert_allclose(inputs.gyr * np.array(TO_PAPER), rate, rtol=0, atol=1e-15)
    assert float(inputs.acc[:, 1].sum()) == printed("0.0238196081")


def test_experiment_1_is_the_same_at_rest():
    still, pushed = experiment_1("deg/s"), experiment_2("deg/s")
    np.testing.assert_array_equal(still.gyr, pushed.gyr)
    np.testing.assert_array_equal(still.acc[:, [0, 2]], pushed.acc[:, [0, 2]])
    push = np.asarray(pushed.acc - still.acc)[:, 1]
    # the two sums differ in one rounding of a number below 1
    np.testing.assert_allclose(push, oracle.bursts(480), rtol=0, atol=2e-16)
    assert not push[:59].any()


# ---------------------------------------------------------------------------------------- rows


def test_every_row_is_there():
    assert [claim.name for claim in CLAIMS] == [
        "exp2.order_S_phi",
        "exp2.pitch_equal",
        "exp2.r2_over_r1",
        "exp2.signed_residual_worse_than_standard",
        "exp1.M_theta",
        "exp1.M_phi",
        "standard_equals_two_step_constant_R",
        "false_alarm_rate_delta",
        "tuned_over_heuristic_heldout",
    ]
    assert list(rows()) == [claim.name for claim in CLAIMS[:-1]]


def test_the_two_step_filter_is_best_in_roll():
    row = rows()["exp2.order_S_phi"]
    assert row.verdict is Verdict.HOLDS
    # six digits each, so the ratio is good to 2e-6
    assert row.ours == pytest.approx(0.361249 / 1.56722, rel=5e-6)
    assert row.ours == pytest.approx(paper("two-step")[0][1] / paper("simple")[0][1], rel=1e-9)
    assert "S_phi 30.3 standard, 1.57 simple, 0.361 two-step" in row.note


def test_pitch_is_alike():
    row = rows()["exp2.pitch_equal"]
    assert row.verdict is Verdict.HOLDS
    pitch = [paper(law)[0][0] for law in oracle.LAWS]
    share = (max(pitch) - min(pitch)) / paper("standard")[0][1]
    assert row.ours == pytest.approx(share, rel=1e-9)
    assert row.ours == pytest.approx((0.0105680 - 0.00532724) / 30.2810, rel=1e-4)


def test_the_variance_grows_across_the_push():
    row = rows()["exp2.r2_over_r1"]
    found = oracle.run(*oracle.experiment2(), "two-step")
    assert row.verdict is Verdict.HOLDS
    # the largest of 480 variances that follow the residual: 1e-12 rad of it times 10 over 0.05
    assert row.ours == pytest.approx(found["r2"].max() / found["r1"].max(), rel=1e-9)
    assert row.ours > 2


def test_a_signed_residual_is_worse_than_no_adaptation():
    row = rows()["exp2.signed_residual_worse_than_standard"]
    assert row.verdict is Verdict.INCONSISTENT
    # printed with six digits each
    assert row.ours == pytest.approx(136.337 / 30.2810, rel=5e-6)
    assert row.ours == pytest.approx(4.5024, abs=5e-5)
    assert "S_phi 136.3 deg^2, standard 30.28, with the absolute value 0.361" in row.note


@pytest.mark.parametrize(("at", "name", "value"), [(0, "M_theta", 0.733), (1, "M_phi", 0.909)])
def test_errors_at_rest_are_not_identifiable(at, name, value):
    row = rows()[f"exp1.{name}"]
    assert row.verdict is Verdict.NOT_IDENTIFIABLE
    assert row.paper == value
    assert row.tolerance is None
    for unit in ("deg", "rad"):
        acceleration, rate = oracle.noise(480, unit)
        found = oracle.run(acceleration + np.array([0.0, 0.0, 1.0]), rate, "two-step")
        largest = oracle.errors(found["theta"], found["phi"])[1][at]
        assert f"{largest:.3g} in ({unit}/s)^2" in row.note
        if unit == "deg":
            assert row.ours == pytest.approx(largest, rel=1e-9)


def test_with_a_constant_variance_both_filters_are_one():
    row = rows()["standard_equals_two_step_constant_R"]
    assert row.verdict is Verdict.HOLDS
    assert row.ours < 1e-12
    assert "differ by 1.6e-05 rad" in row.note


def test_delta_detects_at_rest():
    row = rows()["false_alarm_rate_delta"]
    assert row.verdict is Verdict.INCONSISTENT
    assert row.paper is None
    assert row.ours == pytest.approx(0.5419, abs=5e-5)
    # the row leaves out the square of the noise
    assert row.ours == pytest.approx(oracle.false_alarm_rate(), abs=1e-3)


# --------------------------------------------------------------------------------------- tuning


def test_what_cannot_be_tuned_on_is_refused(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    words = ["tune_on=experiment2", "seconds=20", "train=1", "held_out=1"]
    sets = [part for word in words for part in ("--set", word)]
    assert invoke(["run", "suh2004", *sets, "--out", "run"]) == 2
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.startswith("tuner: the attitude in these data never moves")
    assert "q1" in said.err
    assert said.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_claim_is_tried_alone(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    words = ["--claim", "exp2.r2_over_r1", "--set", "seconds=20", "--set", "train=1"]
    assert invoke(["run", "suh2004", *words, "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    (row,) = result["comparisons"]
    assert row["ours"] == rows()["exp2.r2_over_r1"].ours
    assert result["solutions"] == []


def test_what_is_exported():
    found = problems.posed(recordings(SHORT, 1, 0))["two_step"]
    start = estimates(found, found.space.start(), yardstick(found, found.space.start()), None)
    solution = SimpleNamespace(parameters=start)
    told = {quantity.name: quantity for quantity in found.quantities(solution)}
    assert list(told) == [*problems.BY_HAND]
    assert float(told["r3"].value) == 1.0
    assert told["gravity"].unit == "g"
    assert found.what_is_exported().states[:2] == ("pitch", "roll")
    assert all(quantity.meaning for quantity in told.values())


def test_a_moving_record_poses_all_three():
    posed = problems.posed(recordings(SHORT, 1, 0))
    assert set(posed) == {"standard", "simple", "two_step"}
    for name, problem in posed.items():
        # a threshold is held, so that what is left is smooth
        assert not problem.space.thresholds().any()
        assert problem.space.size == {"standard": 1, "simple": 2, "two_step": 3}[name]
        starts = problem.starts(4, 0)
        assert len(np.unique(starts, axis=0)) == 4
        assert problem.starts(4, 1).tolist() == starts.tolist()  # none is random


def test_from_every_start_the_same_optimum_is_reached():
    """Of the two-step filter, whose error has basins from which no slope leads out."""
    problem = problems.posed(recordings(SHORT, 1, 0))["two_step"]
    found = Gradient("l-bfgs-b", seed=0, starts=4, gradient=1e-6, curvature=False)(problem)
    starts = found.certificate.starts
    assert (starts.count, starts.agreeing) == (4, 4)


def same(one: Recordings, other: Recordings):
    pairs = zip([*one.inputs, one.truth], [*other.inputs, other.truth], strict=True)
    return [np.array_equal(a, b) for a, b in pairs]


def test_records_follow_their_seeds():
    two = recordings(SHORT, 2, 5)
    assert two.count == 2
    assert two.inputs.gyr.shape == (400, 2, 3)
    assert all(same(two, recordings(SHORT, 2, 5)))
    assert not any(same(two, recordings(SHORT, 2, 6)))
    # the second record of seed 5 is the first of seed 6
    second, first = recordings(SHORT, 2, 5), recordings(SHORT, 1, 6)
    np.testing.assert_array_equal(second.truth[:, 1], first.truth[:, 0])
    np.testing.assert_array_equal(second.inputs.gyr[:, 1], first.inputs.gyr[:, 0])


def test_held_out_error_is_the_textbooks():
    judged_on = recordings(SHORT, 1, 1000)
    acceleration, rate = (np.asarray(leaf)[:, 0] for leaf in judged_on.inputs)
    assert HEURISTIC.items() <= oracle.DEFAULTS.items()
    found = oracle.run(acceleration, rate * TO_PAPER, "two-step")
    error = np.stack([found["theta"], found["phi"]], axis=1) - np.asarray(judged_on.truth)[:, 0]
    by_hand = np.degrees(np.sqrt((error**2).sum(axis=1).mean()))
    # 400 samples' rounding
    problem = bench(SHORT, 0).problems["two_step"]
    assert held_out(problem, {}, judged_on) == pytest.approx(by_hand, rel=1e-9)
    assert 0.1 < by_hand < 20


def test_the_records_are_in_the_papers_polarity():
    """ax = sin theta, ay = sin phi cos theta at rest, and the rates turn the angles."""
    still = recordings(Settings(seconds=20.0, burst=0.0, bias=0.0), 1, 3)
    theta, phi = np.asarray(still.truth)[:, 0].T
    ax, ay, az = np.asarray(still.inputs.acc)[:, 0].T
    # noise of 4e-3 g
    np.testing.assert_allclose(ax, np.sin(theta), atol=0.025)
    np.testing.assert_allclose(ay, np.sin(phi) * np.cos(theta), atol=0.025)
    np.testing.assert_allclose(az, np.cos(phi) * np.cos(theta), atol=0.025)
    rates = np.asarray(still.inputs.gyr)[:, 0] * np.array(TO_PAPER)
    turned = [oracle.rates_matrix(p, t) @ w for p, t, w in zip(phi, theta, rates, strict=True)]
    slopes = np.stack([np.gradient(theta, 0.05), np.gradient(phi, 0.05)], axis=1)
    # noise of 1e-3 rad/s, and differences over 0.1 s of angles of at most 0.4 Hz
    np.testing.assert_allclose(np.array(turned)[1:-1], slopes[1:-1], atol=0.03)
