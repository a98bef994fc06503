"""The study of a sensor at rest: densities, filters, units, lengths, and what is refused."""

import json
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq, minimize, minimize_scalar

from filters import LevelSample, LocalLevel, LocalLevelNoise, run
from studies.rest import STUDY
from studies.rest.averages import Averages, most_likely
from studies.rest.curve import read_noise
from studies.rest.findings import findings, output_on, per_second
from studies.rest.problems import filter_problem, rest_of
from studies.rest.requirement import (
    Requirement,
    bandwidth,
    error_variance,
    kalman_gain,
    knee,
    settling,
)
from studies.rest.settings import Settings
from tuner import Record
from tuner.data.allan import allan_curve
from tuner.run.study import best

N, K, RATE = 0.01, 2e-3, 20.0


def noise(seconds, seed=0, rate=RATE, walk=K):
    draw = np.random.default_rng(seed)
    count = round(seconds * rate)
    white = N * np.sqrt(rate) * draw.standard_normal(count)
    return white + np.cumsum(walk / np.sqrt(rate) * draw.standard_normal(count))


def rests(values, unit="deg/s", rate=RATE, **settings):
    record = Record.of({"z": values}, rate_hz=rate, units={"z": unit})
    return STUDY.plan(Settings(**settings), (record,), 0, "").case


def solved(values, unit="deg/s", **settings):
    record = Record.of({"z": values}, rate_hz=RATE, units={"z": unit})
    plan = STUDY.plan(Settings(starts=1, **settings), (record,), 0, "")
    solutions = {(t.problem.name, t.solver.name): t.solver(t.problem) for t in plan.tasks}
    return {f.name: f for f in findings(plan.case, solutions)}, solutions


@pytest.fixture(scope="module")
def found():
    return solved(noise(1000), settles_s=1.0)


def test_both_methods_find_what_was_put_in(found):
    rows, _ = found
    for how in ("curve", "likelihood"):
        for name, true in (("N", N), ("K", K)):
            row = rows[f"z.{name}.{how}"]
            assert row.low < true < row.high, (name, how, row)
            # Three deviations of what chance does at this length.
            assert row.value == pytest.approx(true, rel=0.3 if name == "K" else 0.02)


def test_the_filters_own_search_ends_where_the_exact_likelihood_does(found):
    rows, solutions = found
    derived = best("z_noise", solutions).derived
    scale = 180 / np.pi
    assert scale * derived["N"] == pytest.approx(rows["z.N.likelihood"].value, rel=1e-4)
    assert scale * derived["K"] == pytest.approx(rows["z.K.likelihood"].value, rel=1e-3)


def test_units_of_data_sheets_and_kalibr(found):
    rows, _ = found
    N_, K_ = rows["z.N.likelihood"].value, rows["z.K.likelihood"].value
    assert rows["z.ARW.likelihood"].value == pytest.approx(60 * N_)
    assert rows["z.RRW.likelihood"].value == pytest.approx(3600 * 60 * K_)
    assert rows["z.gyroscope_noise_density.likelihood"].value == pytest.approx(np.radians(N_))
    assert rows["z.gyroscope_random_walk.likelihood"].unit == "rad/s^2/sqrt(Hz)"
    assert rows["z.R"].value == pytest.approx(N_**2 * RATE)
    assert rows["z.Q"].value == pytest.approx(K_**2 / RATE)
    assert rows["z.bias_instability"].value == pytest.approx(3600 * rows["z.B"].value)
    assert per_second("deg/s") == "deg/s^2"


def test_the_closed_form_and_the_search_agree_and_hold_the_demand(found):
    _, solutions = found
    known, searched = solutions["z", "closed form"], solutions["z", "ipopt"]
    assert known.status.trusted
    assert searched.status.trusted
    assert float(searched.parameters["K1"].value) == pytest.approx(
        float(known.parameters["K1"].value), rel=1e-6
    )
    assert known.certificate.multipliers["settles_s"] > 0.5


def test_the_output_is_as_noisy_as_predicted(found):
    rows, _ = found
    assert rows["z.output"].value == pytest.approx(rows["z.output_seen"].value, rel=0.1)


def test_unit_and_length_do_not_decide():
    whole = noise(1000)
    (one,) = rests(whole, settles_s=1.0)
    (other,) = rests(np.radians(whole), "rad/s", settles_s=1.0)
    (short,) = rests(whole[: round(60 * RATE)], settles_s=1.0)
    assert one.gain == pytest.approx(other.gain, rel=1e-9)
    assert one.white.value == pytest.approx(other.white.value, rel=1e-6)
    assert one.gain == pytest.approx(short.gain, rel=0.01)
    assert short.white.low < one.white.value < short.white.high


def test_no_walk_is_a_limit_from_above():
    rows, solutions = solved(noise(60, walk=0.0, seed=3))
    row = rows["z.K.likelihood"]
    assert row.low is None
    assert row.high > 0
    assert best("z", solutions).status.trusted


# The parts, each against something else.


def adev(values, m, rate):
    """Half the mean square difference of neighbouring means, one by one."""
    means = [values[i : i + m].mean() for i in range(len(values) - m + 1)]
    apart = [means[i + m] - means[i] for i in range(len(means) - m)]
    return np.sqrt(np.mean(np.square(apart)) / 2)


def test_allan_deviations_are_those_of_the_definition():
    values = np.random.default_rng(1).standard_normal(300)
    curve = allan_curve(values, 10.0)
    for m, tau, deviation in zip(curve.factors, curve.taus, curve.deviations, strict=True):
        assert deviation == pytest.approx(adev(values, int(m), 10.0), rel=1e-9)
        assert tau == pytest.approx(m / 10)


def test_allan_limits_cover():
    """Of white noise at every averaging time; 400 curves give the share to 2.5 %."""
    inside = []
    for seed in range(400):
        curve = allan_curve(np.random.default_rng(seed).standard_normal(300), 1.0)
        true = 1 / np.sqrt(curve.factors)
        inside.append((curve.lows <= true) & (true <= curve.highs))
    share = np.mean(inside, axis=0)
    assert (share > 0.90).all(), share
    assert share.mean() < 0.98


def test_the_likelihood_by_sines_is_the_filters():
    averages = Averages.of(noise(50), 1 / RATE, 3)

    def nats(white, walk):
        level = averages.level(white, walk)
        params = LocalLevelNoise(jnp.array(level.Q / averages.step), jnp.array(level.R))
        filter = LocalLevel(averages.step)
        outputs = run(filter, params, LevelSample(jnp.asarray(averages.means)))[1]
        s, y = np.asarray(outputs.variance)[1:], np.asarray(outputs.innovation)[1:]
        return 0.5 * float(np.sum(np.log(s) + y**2 / s))

    for white, walk in ((N, K), (2 * N, 0.3 * K), (N, 5 * K)):
        assert nats(white, walk) == pytest.approx(averages.nats(white, walk), rel=1e-10)


def test_profile_limits_are_where_the_likelihood_says():
    averages = Averages.of(noise(200), 1 / RATE, 1)
    white, walk = most_likely(averages)

    def profile(at):
        other = lambda x: averages.nats(np.exp(x), at)  # noqa: E731
        return minimize_scalar(other, bounds=(np.log(N / 3), np.log(3 * N)), method="bounded").fun

    least = averages.nats(white.value, walk.value)
    for end in (walk.low, walk.high):
        assert profile(end) - least == pytest.approx(1.9207, abs=0.01)


@pytest.mark.parametrize("walk", [1e-5, 1e-3, 0.1])
def test_the_most_likely_is_found_wherever_it_is(walk):
    """Against scipy's simplex search from the truth; the walk of 1e-5 cannot be told from none."""
    averages = Averages.of(noise(200, walk=walk), 1 / RATE, 1)
    found = most_likely(averages)

    def nats(x):
        return averages.nats(*np.exp(x))

    other = minimize(nats, np.log([N, walk]), method="Nelder-Mead", options={"fatol": 1e-9})
    least = averages.nats(found[0].value, found[1].value)
    assert least <= other.fun + 1e-6
    assert found[0].value == pytest.approx(np.exp(other.x[0]), rel=1e-3)
    assert found[0].low < N < found[0].high
    assert found[1].known == (walk > 1e-4)


def test_limits_cover():
    """Of 200 records at either end of what can be told; 95 % to 3 deviations of the count."""
    inside = []
    for seed in range(200):
        white, walk = most_likely(Averages.of(noise(100, seed, walk=0.01), 1 / RATE, 1))
        inside.append((white.low <= N <= white.high, walk.low <= 0.01 <= walk.high))
    assert (np.abs(np.mean(inside, axis=0) - 0.95) < 0.046).all(), np.mean(inside, axis=0)


def test_means_of_a_walk_are_a_level_with_the_rates_told():
    """Exact covariances of increments of block means, from the walk's own."""
    m, walk, white = 7, 0.3, 1.1
    averages = Averages(m, 0.5, np.zeros(3), np.zeros(2), np.zeros(2))
    level = averages.level(white, walk)
    count = 3 * m
    summed = np.tril(np.ones((count, count))) * walk * np.sqrt(0.5)
    covariance = summed @ summed.T + white**2 / 0.5 * np.eye(count)
    block = np.kron(np.eye(3), np.ones((1, m)) / m)
    increments = np.diff(np.eye(3), axis=0) @ block
    found = increments @ covariance @ increments.T
    assert found[0, 0] == pytest.approx(level.Q + 2 * level.R, rel=1e-12)
    assert found[0, 1] == pytest.approx(-level.R, rel=1e-12)
    assert averages.densities(*level) == pytest.approx((white, walk), rel=1e-12)


def test_a_sensors_own_filter_does_not_lower_the_density():
    white = np.random.default_rng(2).standard_normal(200_000)
    smooth = np.convolve(white, np.ones(10) / 10, "valid")  # white from ten samples on
    found = read_noise(allan_curve(smooth, 100.0))
    assert found.from_s > 0.15
    # 200,000 samples tell it to 2 %, averaged over as long as it is white.
    assert found.white.value == pytest.approx(0.1, rel=0.03)


@pytest.mark.parametrize("dt", [0.01, 0.002])
def test_gains_do_what_was_asked(dt):
    K1 = Requirement("settles_s", 1.0, dt).gain
    assert (1 - K1) ** round(1 / dt) == pytest.approx(0.02, rel=1e-9)
    assert settling(K1, dt) == pytest.approx(1.0)
    K1 = Requirement("bandwidth_hz", 2.0, dt).gain
    pole = np.exp(2j * np.pi * 2.0 * dt)
    assert abs(K1 / (1 - (1 - K1) / pole)) ** 2 == pytest.approx(0.5, rel=1e-9)
    assert bandwidth(K1, dt) == pytest.approx(2.0)
    K1 = Requirement("latency_s", 0.1, dt).gain
    ramp, x = np.arange(5000) * dt, 0.0
    for z in ramp:
        x += K1 * (z - x)
    assert ramp[-1] - x == pytest.approx(0.1, rel=1e-9)


def test_the_error_variance_is_the_loops():
    """Of a long simulated run, to the 2 % that its length allows."""
    draw, gain, R, Q = np.random.default_rng(4), 0.2, 4.0, 0.3
    level = np.cumsum(np.sqrt(Q) * draw.standard_normal(200_000))
    z, x, errors = level + np.sqrt(R) * draw.standard_normal(200_000), 0.0, []
    for k in range(len(z)):
        x += gain * (z[k] - x)
        errors.append(x - level[k])
    assert np.var(errors[100:]) == pytest.approx(float(error_variance(gain, R, Q)), rel=0.02)
    least = minimize_scalar(lambda k: float(error_variance(k, R, Q)), bounds=(0.01, 0.9)).x
    assert kalman_gain(R, Q) == pytest.approx(least, rel=1e-4)


def test_the_knee_is_where_twice_the_latency_gains_a_tenth():
    R, Q, dt = 1.0, 1e-8, 0.01

    def gain(delay):
        once, twice = (float(error_variance(dt / (d + dt), R, Q)) for d in (delay, 2 * delay))
        return np.sqrt(twice / once) - 0.9

    assert knee(R, Q, dt) == pytest.approx(brentq(gain, 1.0, 90.0), rel=0.01)


def test_a_bias_that_walks_fast_keeps_its_own_gain():
    (rest,) = rests(noise(1000, walk=0.05), latency_s=30.0)
    assert rest.gain == pytest.approx(kalman_gain(rest.R, rest.Q))
    solution = filter_problem(rest)
    assert rest.requirement.measure(jnp.array(rest.gain), None) < 30.0
    assert solution.value(solution.space.start()) > 0


def test_output_on_a_record_of_white_noise():
    values = np.random.default_rng(5).standard_normal(100_000)
    assert output_on(values, 0.1) == pytest.approx(np.sqrt(0.1 / 1.9), rel=0.03)


# What is refused.


def refused(values, match, rate=RATE, **settings):
    with pytest.raises(ValueError, match=match):
        rests(values, rate=rate, **settings)


def test_demands_that_no_filter_meets_and_short_records():
    values = noise(60)
    refused(values, "no filter settles within 0.01 s", settles_s=0.01)
    refused(values, "half the rate", bandwidth_hz=10.0)
    refused(values, "lasts 60 s.*record at rest for", latency_s=30.0)
    refused(values[:50], "has 50 samples")
    refused(np.ones(500), "is constant")
    with pytest.raises(ValueError, match="give one"):
        Settings(settles_s=1.0, latency_s=1.0)


def test_missing_samples_name_the_part_without():
    values = noise(60)
    values[300] = np.nan
    refused(values, "misses 1 sample,.*--from 15.05 --to 59.95")


def test_motion_is_refused_with_the_place_of_rest():
    t = np.arange(1200) / RATE
    values = noise(60) + np.where((t > 10) & (t < 25), np.sin(3 * t), 0.0)
    refused(values, r"is not at rest.*it rests from 2[5-9].* s to 60 s: --from")


def test_an_axis_of_three_by_command_line(cli_run):
    rows = noise(60)[:, None] * [1.0, 2.0, 3.0] + noise(60, seed=1)[:, None]
    np.savez("rest.npz", gyr=rows)
    words = ["run", "rest", "--log", "rest.npz", "--map", "gyr=gyr:deg/s", "--rate", "20"]
    code, out = cli_run(
        *words,
        "--from",
        "10",
        "--set",
        "settles_s=1",
        "--set",
        "starts=1",
        "--json",
        "--out",
        "out",
    )
    assert code == 0
    result = json.loads(out)
    names = {row["name"].split(".")[0] for row in result["findings"]}
    assert names == {"gyr_x", "gyr_y", "gyr_z"}
    assert result["log"]["samples"] == 1000
    header = Path("out/exports/gyr_x.h").read_text()
    assert "gyr_x_step" in header
    assert len(result["exports"]) == 21


@pytest.fixture
def cli_run(tmp_path, monkeypatch, capfd):
    from tuner.cli import invoke

    monkeypatch.chdir(tmp_path)

    def run_(*words):
        capfd.readouterr()
        code = invoke(list(words))
        return code, capfd.readouterr().out

    return run_


def test_rest_of_takes_the_machines_rate():
    (rest,) = rests(noise(1000))
    (faster,) = rests(noise(1000), rate_hz=100.0)
    assert pytest.approx(5 * rest.R) == faster.R
    assert pytest.approx(rest.Q / 5) == faster.Q
    assert rest_of(rest.axis, None, {}).requirement is None
