"""Kownacki's filters: against the two-state models, 40 digits, and the published numbers."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from scipy.optimize import brentq

from filters import (
    AccelerometerFilter,
    FixedGainFilter,
    FixedGains,
    GyroscopeFilter,
    KownackiNoise,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
    accelerometer_steady,
    gyroscope_steady,
    run,
)
from tests.oracles import exact_inertial, response, rise_time
from tests.published import (
    ACC_1,
    ACC_2,
    GYRO_1,
    GYRO_2,
    STEP,
    T,
    as_printed,
    d1_noise,
    d1_step,
    step_signal,
)
from tests.strategies import noise_ratios

compiled = jax.jit(run, static_argnums=0)
steady_accelerometer = jax.jit(accelerometer_steady, static_argnums=1)
steady_gyroscope = jax.jit(gyroscope_steady, static_argnums=1)

ACC, GYRO = AccelerometerFilter(T), GyroscopeFilter(T)
MEASURED = {ACC: 1, GYRO: 0}  # the state that is measured
both = pytest.mark.parametrize("filter", [ACC, GYRO], ids=["acc", "gyro"])


def outputs(filter, noise, z):
    return np.asarray(compiled(filter, KownackiNoise.of(*noise), jnp.asarray(z))[1])


def two_states(filter, R, Q, P0):
    """Models (8) and (9) of the paper: Phi = [1 T; 0 1], G = T I, H = [0 1] or [1 0]."""
    return LinearModel(
        transition=Transition(
            F=jnp.array([[1.0, filter.dt], [0.0, 1.0]]), G=filter.dt * jnp.eye(2), Q=Q * jnp.eye(2)
        ),
        H=jnp.eye(2)[MEASURED[filter]][None],
        R=jnp.array([R]),
        P0=jnp.asarray(P0),
        x0=jnp.zeros(2),
    )


@cache
def d1(filter, noise):
    """The filter's answer to D1: y_0 = 0, updates from k = 1."""
    return np.concatenate([[0.0], outputs(filter, noise, (d1_step() + d1_noise())[1:])])


# --- what the filters are ------------------------------------------------------------------------


@both
@pytest.mark.parametrize(
    "noise", [ACC_1, ACC_2, GYRO_1, GYRO_2, (1e-12, 1e-3), (1.0, 0.0)], ids=str
)
def test_equals_the_linear_filter_on_the_two_state_model(filter, noise):
    z = (d1_step() + d1_noise())[4000:7000]
    # P0 in units of R: the general filter stores P itself and loses P0 / R of its digits.
    P0 = noise[0] * np.array([[2.0, 1.0], [1.0, 0.5]])
    states = compiled(LinearKalman(), two_states(filter, *noise, P0), Sample(z[:, None]))[1]
    actual = compiled(filter, KownackiNoise(*noise, jnp.asarray(P0)), jnp.asarray(z))[1]
    expected = np.asarray(states.x)[:, MEASURED[filter]]
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-12 * STEP)  # 3000 rounded steps


@both
@pytest.mark.parametrize("P0", ["ones", "zero", "full"])
@pytest.mark.parametrize("noise", [(1e-12, 1e-9), (1e-12, 0.0), ACC_2, GYRO_1], ids=str)
def test_keeps_twelve_digits_of_the_step(filter, P0, noise):
    """Against 40 digits, at the smallest R that a tuner tries, with missing samples.

    The project promises nine digits. The textbook's P22 - K P12 keeps four of them at the first
    of these noises and three at the third, for P0 = ones.
    """
    start = {"ones": np.ones((2, 2)), "zero": np.zeros((2, 2)), "full": [[2.0, 0.5], [0.5, 1.0]]}[
        P0
    ]
    z = (d1_step() + d1_noise())[4900:5300]
    z[100:130], z[301] = np.nan, np.nan
    _, actual = compiled(filter, KownackiNoise(*noise, jnp.asarray(start)), jnp.asarray(z))
    expected = exact_inertial(T, (*noise, start), z, MEASURED[filter])
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-12 * STEP)  # 400 rounded steps


@both
def test_missing_samples_are_those_of_the_two_state_model(filter):
    z = d1_noise()[:500] + STEP
    z[[0, 3]], z[200:260] = np.nan, np.nan
    P0 = np.array([[2.0, 0.3], [0.3, 1.0]])
    states = compiled(LinearKalman(), two_states(filter, 1e-6, 1e-3, P0), Sample(z[:, None]))[1]
    _, actual = compiled(filter, KownackiNoise(1e-6, 1e-3, jnp.asarray(P0)), jnp.asarray(z))
    expected = np.asarray(states.x)[:, MEASURED[filter]]
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-12 * STEP)


@both
def test_only_the_ratio_of_the_covariances_counts(filter):
    z = (d1_step() + d1_noise())[4000:7000]
    for c in (1e-6, 7.3, 1e8):
        one = compiled(filter, KownackiNoise(1e-6, 1e-3, jnp.ones((2, 2))), jnp.asarray(z))[1]
        other = compiled(
            filter, KownackiNoise(c * 1e-6, c * 1e-3, c * jnp.ones((2, 2))), jnp.asarray(z)
        )[1]
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-12 * STEP)  # rounding of c * R


@both
def test_P0_is_forgotten_so_only_q_over_r_is_left(filter):
    """Notes: (R, Q) -> c (R, Q) leaves the output unchanged to 1e-9 once P0 has gone."""
    z = d1_step() + d1_noise()
    one, other = outputs(filter, (1e-8, 1e-2), z), outputs(filter, (1e-7, 1e-1), z)
    np.testing.assert_allclose(other[5000:], one[5000:], rtol=0, atol=1e-9)


def test_without_process_noise_the_accelerometer_filter_is_the_running_mean():
    z = d1_noise()[:2000] + STEP
    mean = np.cumsum(z) / (np.arange(2000) + 1 + 1e-6)  # P0 = 1 counts as R = 1e-6 of a sample
    np.testing.assert_allclose(outputs(ACC, (1e-6, 0.0), z), mean, rtol=1e-12)  # 2000 sums


def test_velocity_of_the_accelerometer_model_only_grows():
    """It cannot be observed: its variance grows by T^2 (R + Q) a sample in the steady state."""
    R, Q = 1e-4, 1e4
    ones = Sample(jnp.ones((2000, 1)))
    P = np.asarray(compiled(LinearKalman(), two_states(ACC, R, Q, np.ones((2, 2))), ones)[1].P)
    growth = np.diff(P[-100:, 0, 0])
    np.testing.assert_allclose(growth, T**2 * (R + Q), rtol=1e-7)  # 1e-16 of P11 = 1 in 1e-4


@pytest.mark.parametrize("kind", [AccelerometerFilter, GyroscopeFilter, FixedGainFilter])
def test_several_signals_are_several_filters(kind):
    params = FixedGains(0.3, 0.1) if kind is FixedGainFilter else KownackiNoise.of(1e-3, 10.0)
    z = np.random.default_rng(2).normal(size=(50, 3))
    z[20, 1] = np.nan  # missing in one is missing in all
    together = compiled(kind(0.1, (3,)), params, jnp.asarray(z))[1]
    z[20] = np.nan
    for i in range(3):
        alone = compiled(kind(0.1), params, jnp.asarray(z[:, i]))[1]
        np.testing.assert_allclose(together[:, i], alone, rtol=1e-13)  # fused in another order


@pytest.mark.parametrize("kind", [AccelerometerFilter, GyroscopeFilter, FixedGainFilter])
def test_float32_in_is_float32_throughout(kind):
    """The check of a tuned filter in single precision must not be helped by a hidden double."""
    single = jnp.float32
    params = (
        FixedGains(single(0.3), single(0.1))
        if kind is FixedGainFilter
        else KownackiNoise(single(1e-3), single(10.0), jnp.ones((2, 2), single))
    )
    step = jax.make_jaxpr(kind(0.1).step)(params, kind(0.1).init(params), single(0.2))
    used = {variable.aval.dtype for line in step.eqns for variable in line.outvars}
    assert jnp.dtype("float64") not in used
    state, put_out = run(kind(0.1), params, jnp.ones(20, single))
    assert {leaf.dtype for leaf in jax.tree.leaves((state, put_out))} == {jnp.dtype("float32")}


@pytest.mark.parametrize("noise", [GYRO_1, GYRO_2, ACC_2], ids=["gyro 1", "gyro 2", "acc 2"])
@both
def test_single_precision_keeps_three_digits_of_the_step(filter, noise):
    """At 10 kHz and P0 = ones the textbook's covariance is wrong by 0.2 of the step (table 1)."""
    z = d1_step() + d1_noise()
    single = KownackiNoise(*(jnp.float32(v) for v in noise), jnp.ones((2, 2), jnp.float32))
    rounded = compiled(filter, single, jnp.asarray(z, jnp.float32))[1]
    # Where the gain is 1e-4 a sample's correction is rounded at 6e-8 / 1e-4 of itself.
    np.testing.assert_allclose(rounded, outputs(filter, noise, z), rtol=0, atol=1e-3 * STEP)


def test_single_precision_of_the_fixed_gain_filter():
    """Fixed gains need no covariance; what is left is the rounding of the level itself."""
    z = d1_step() + d1_noise()
    gains = steady_gyroscope(GYRO_2[1] / GYRO_2[0], T).gains
    whole = compiled(FixedGainFilter(T), gains, jnp.asarray(z))[1]
    single = FixedGains(jnp.float32(gains.K1), jnp.float32(gains.K2))
    rounded = compiled(FixedGainFilter(T), single, jnp.asarray(z, jnp.float32))[1]
    # 6e-8 a sample, remembered for some 1 / K1 = 300 samples
    np.testing.assert_allclose(rounded, whole, rtol=0, atol=300 * 6e-8 * STEP)


# --- published numbers ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("filter", "noise", "printed"),
    [
        (ACC, ACC_2, ["4.99083e-4", "6.71237e-4", "8.53232e-5", "0.0768134", "0.199834"]),
        (GYRO, GYRO_2, ["4.99083e-4", "6.73828e-4", "5.52736e-4", "0.194567", "0.200812"]),
        (GYRO, GYRO_1, ["4.99082e-4", "6.74577e-4", "5.43358e-5", "0.0481073", "0.233651"]),
    ],
    ids=["acc 2", "gyro 2", "gyro 1"],
)
def test_table_of_D1(filter, noise, printed):
    y = d1(filter, noise)
    assert [y[k] for k in (1, 100, 5000, 6000, 20000)] == [as_printed(text) for text in printed]


@pytest.mark.parametrize(
    ("noise", "r", "K1", "bandwidth"),
    [
        (ACC_1, "6.41999e-5", "8.01248e-7", "0.00127523"),
        (ACC_2, "22.9537", "4.78986e-4", "0.762512"),
    ],
    ids=["table 1", "table 2"],
)
def test_steady_accelerometer_as_published(noise, r, K1, bandwidth):
    R, Q = noise
    steady = steady_accelerometer(Q / R, T)
    assert as_printed(r) == Q / R
    assert as_printed(K1) == steady.gains.K1
    assert steady.gains.K2 == 0
    assert steady.bandwidth_hz == as_printed(bandwidth)


@pytest.mark.parametrize(
    ("noise", "r", "K1", "K2", "bandwidth"),
    [
        (GYRO_1, "1.79549e-3", "2.94176e-5", "4.23726e-6", "0.0677475"),
        (GYRO_2, "1027.47", "3.29845e-3", "3.20013e-3", "5.41212"),
    ],
    ids=["table 1", "table 2"],
)
def test_steady_gyroscope_as_published(noise, r, K1, K2, bandwidth):
    R, Q = noise
    steady = steady_gyroscope(Q / R, T)
    assert as_printed(r) == Q / R
    assert as_printed(K1) == steady.gains.K1
    assert as_printed(K2) == steady.gains.K2
    assert steady.bandwidth_hz == as_printed(bandwidth)


@pytest.mark.parametrize(
    ("steady", "noise", "samples", "printed"),
    [
        (steady_accelerometer, ACC_1, 3_000_000, "274.2"),
        (steady_accelerometer, ACC_2, 10_000, "0.4587"),
        (steady_gyroscope, GYRO_1, 100_000, "4.0946"),
        (steady_gyroscope, GYRO_2, 10_000, "0.0615"),
    ],
    ids=["acc 1", "acc 2", "gyro 1", "gyro 2"],
)
def test_rise_time_as_published(steady, noise, samples, printed):
    R, Q = noise
    answer = compiled(FixedGainFilter(T), steady(Q / R, T).gains, jnp.ones(samples))[1]
    assert rise_time(np.asarray(answer), T) == as_printed(printed)


def test_gains_of_table_1_are_not_steady_within_the_record():
    """Notes: at 5 s the accelerometer's gain is still about 1/k = 2e-5, not 8e-7."""
    R, Q = ACC_1
    state, _ = compiled(ACC, KownackiNoise.of(R, Q), jnp.zeros(50_000))
    assert state.p == pytest.approx(2e-5, rel=0.01)


def test_lag_of_table_1_is_unacceptable():
    """Notes: 5 s after a step of 0.2 the accelerometer filter has reached 0.1001."""
    assert outputs(ACC, ACC_1, step_signal(100_001, 50_000)[1:])[-1] == as_printed("0.1001")


def test_gyroscope_filter_of_table_2_overshoots():
    """Notes on figure 9: 90 % of the step after 0.065 s, 2.5 % of overshoot."""
    y = outputs(GYRO, GYRO_2, step_signal(100_001, 50_000)[1:])
    assert np.argmax(y >= 0.9 * STEP) * T - 5.0 == as_printed("0.065")
    assert 100 * (y.max() / STEP - 1) == as_printed("2.5")


# --- steady state --------------------------------------------------------------------------------


@given(r=noise_ratios())
def test_steady_gyroscope_gains_solve_the_riccati_equation(r):
    """Written in the gains, with R = 1 and S = 1 / (1 - K1); every term is positive."""
    gains = steady_gyroscope(r, T).gains
    K1, K2, q = float(gains.K1), float(gains.K2), r * T**2
    S = 1 / (1 - K1)
    p22 = K1 * K2 * S / T  # after an update, from P12- = K2 S = P12+ + T P22+
    # A few roundings in each equation; 1 - K1 costs another at the largest ratio, K1 = 0.3.
    assert pytest.approx(q, rel=1e-13) == K2 * K2 * S  # P22+ = P22+ + q - K2 P12-
    assert pytest.approx(K1 * S, rel=1e-13) == K1 + 2 * T * K2 + T**2 * p22 + q  # P11- = K1 S


@pytest.mark.parametrize("r", [1e-2, 1.0, 1027.47, 1e6])
@pytest.mark.parametrize("dt", [1e-4, 1e-2, 0.3])
def test_steady_gyroscope_gains_equal_scipy(r, dt):
    F, H = np.array([[1.0, dt], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    P = scipy.linalg.solve_discrete_are(F.T, H.T, r * dt**2 * np.eye(2), np.eye(1))
    K = (P @ H.T / (H @ P @ H.T + 1)).ravel()
    gains = steady_gyroscope(r, dt).gains
    # scipy's solver keeps half of the digits at T = 1e-4, where the closed loop's poles are at
    # 1 - 1e-3 (the closed form solves the equation to 1e-12, above)
    np.testing.assert_allclose([gains.K1, gains.K2], K, rtol=1e-8)


@pytest.mark.parametrize("r", [1e-2, 22.95, 1e6])
@pytest.mark.parametrize("dt", [1e-4, 1e-2, 0.3])
def test_steady_accelerometer_gain_equals_scipy(r, dt):
    """On the observable part; with the velocity there is no stabilising solution."""
    one = np.eye(1)
    P = scipy.linalg.solve_discrete_are(one, one, r * dt**2 * one, one).item()
    gains = steady_accelerometer(r, dt).gains
    assert pytest.approx(P / (P + 1), rel=1e-8) == float(gains.K1)  # as above


@pytest.mark.parametrize("r", [1e3, 1e6])
def test_converged_gains_are_the_steady_ones(r):
    """The slowest mode forgets as exp(-t), the covariance twice as fast: 20 s leave 4e-18."""
    noise, still = KownackiNoise.of(1e-6, r * 1e-6), jnp.zeros(200_000)
    level, _ = compiled(ACC, noise, still)
    rate, _ = compiled(GYRO, noise, still)
    acc, gyro = steady_accelerometer(r, T).gains, steady_gyroscope(r, T).gains
    # A fixed point of rounded steps; it forgets them in 1 s, 10 000 of them.
    assert float(level.p) == pytest.approx(float(acc.K1), rel=1e-11)
    assert float(rate.p11) == pytest.approx(float(gyro.K1), rel=1e-11)
    assert float(rate.p12) == pytest.approx(float(gyro.K2), rel=1e-11)


@pytest.mark.parametrize(
    ("kind", "steady"),
    [(AccelerometerFilter, accelerometer_steady), (GyroscopeFilter, gyroscope_steady)],
)
def test_fixed_gains_are_what_either_filter_becomes(kind, steady):
    r, dt = 1e4, 0.01
    z = jnp.asarray(np.random.default_rng(5).normal(size=4000))
    fixed = compiled(FixedGainFilter(dt), steady(r, dt).gains, z)[1]
    varying = compiled(kind(dt), KownackiNoise.of(1e-3, r * 1e-3), z)[1]
    # exp(-t) at 30 s is 1e-13
    np.testing.assert_allclose(fixed[3000:], varying[3000:], rtol=0, atol=1e-11)


@given(r=noise_ratios())
def test_continuous_limit(r):
    """Notes: K1/T -> sqrt(r + 2 sqrt(r)) and K2/T -> sqrt(r) as T -> 0."""
    dt = 1e-9
    gains = steady_gyroscope(r, dt).gains
    # The next term is of relative order K1 = T (2 r^(1/4)) < 1e-9 * 3200 at r = 1e7
    assert gains.K1 / dt == pytest.approx(np.sqrt(r + 2 * np.sqrt(r)), rel=1e-5)
    assert gains.K2 / dt == pytest.approx(np.sqrt(r), rel=1e-5)
    assert steady_accelerometer(r, dt).gains.K1 / dt == pytest.approx(np.sqrt(r), rel=1e-5)


def crossing(magnitude):
    """The first frequency, in radians a sample, at which a response has fallen by 3 dB."""
    grid = np.geomspace(1e-9, np.pi, 400)
    below = np.flatnonzero([magnitude(w) < np.sqrt(0.5) for w in grid])
    if not below.size:
        return np.inf
    k = below[0]
    return brentq(
        lambda w: magnitude(w) - np.sqrt(0.5), grid[k - 1], grid[k], xtol=1e-16, rtol=1e-14
    )


@pytest.mark.parametrize("dt", [1e-4, 1e-2, 0.5])
@pytest.mark.parametrize("r", [1.8e-3, 1.0, 1027.47, 1e5, 1e7])
def test_bandwidth_of_the_gyroscope_filter(r, dt):
    steady = steady_gyroscope(r, dt)
    F, H = np.array([[1.0, dt], [0.0, 1.0]]), np.array([1.0, 0.0])
    K = np.array([steady.gains.K1, steady.gains.K2])
    expected = crossing(lambda w: response(F, K, H, w)) / (2 * np.pi * dt)
    # Near zero frequency 1 - |H| is what is left of a difference: seven digits at the lowest.
    assert float(steady.bandwidth_hz) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("dt", [1e-4, 1e-2, 0.5])
@pytest.mark.parametrize("r", [6.4e-5, 1.0, 22.95, 1e5, 1e9])
def test_bandwidth_of_the_accelerometer_filter(r, dt):
    steady = steady_accelerometer(r, dt)
    one = np.ones((1, 1))
    K = np.array([steady.gains.K1])
    expected = crossing(lambda w: response(one, K, one[0], w)) / (2 * np.pi * dt)
    assert float(steady.bandwidth_hz) == pytest.approx(expected, rel=1e-6)  # as above


def test_bandwidth_of_the_accelerometer_filter_ends_at_half_the_sample_rate():
    """At rho = r T^2 = 4 the response falls by 3 dB at the last frequency there is."""
    assert steady_accelerometer(4.01 / T**2, T).bandwidth_hz == np.inf
    almost = float(steady_accelerometer(3.99 / T**2, T).bandwidth_hz)
    assert 0.95 * 0.5 / T < almost < 0.5 / T


@pytest.mark.parametrize("steady", [steady_accelerometer, steady_gyroscope], ids=["acc", "gyro"])
def test_bandwidth_is_infinite_where_the_response_never_falls_by_3_dB(steady):
    assert steady(1e14, T).bandwidth_hz == np.inf
    assert steady(1e30, T).bandwidth_hz == np.inf


def test_noise_ratio_of_the_accelerometer_filter():
    """White noise comes out with K / (2 - K) of its variance: the sum of the squared weights."""
    gains = steady_accelerometer(1e6, T).gains
    impulse = np.zeros(2000)
    impulse[0] = 1.0
    weights = np.asarray(compiled(FixedGainFilter(T), gains, jnp.asarray(impulse))[1])
    K = float(gains.K1)
    assert (weights**2).sum() == pytest.approx(K / (2 - K), rel=1e-12)  # the rest: (1 - K)^4000


@pytest.mark.parametrize("steady", [steady_accelerometer, steady_gyroscope], ids=["acc", "gyro"])
def test_steady_gains_differentiate(steady):
    gradient = jax.jit(jax.grad(lambda s: steady(jnp.exp(s), T).gains.K1))(3.0)
    h = 1e-4  # h^2 of truncation against 1e-16 / h of rounding
    ahead, behind = (float(steady(np.exp(3 + s), T).gains.K1) for s in (h, -h))
    assert float(gradient) == pytest.approx((ahead - behind) / (2 * h), rel=1e-7)
