"""Attitude from six or nine axes: the gravity filter, Mahony's and Madgwick's."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

from filters import (
    AttitudeKalman,
    AttitudeNoise,
    ImuSample,
    Madgwick,
    MadgwickGain,
    Mahony,
    MahonyGains,
    MahonyState,
    run,
)
from objectives import AttitudeRmse, attitude_error
from tests.oracles import surprise, surprises
from tests.strategies import seeds
from tuner.data.simulation import GRAVITY, Bursts, Sensor, Swing, measure, simulate

N, DT = 2000, 0.02
"""Of every record: shorter ones are padded, for each length is a compilation."""
ONE = np.array([1.0, 0.0, 0.0, 0.0])
SETTINGS = {
    "gyroscope": 1e-6,
    "bias": 1e-10,
    "accelerometer": 1e-4,
    "memory": 0.5,
    "gain": 5.0,
    "delta": 0.03,
    "gravity": GRAVITY,
    "q0": ONE,
    "b0": np.zeros(3),
    "tilt0": 0.5,
    "bias0": 0.05,
}
ADAPTIVE, PLAIN = AttitudeKalman(DT), AttitudeKalman(DT, adaptive=False)

# Without the compiler's optimisation, which changes no formula and takes most of the time.
QUICK = {"xla_backend_optimization_level": 0}
compiled = jax.jit(run, static_argnums=0, compiler_options=QUICK)
errors = jax.jit(jax.vmap(attitude_error))
rmse = jax.jit(AttitudeRmse())


def noise(**settings):
    return AttitudeNoise(**{k: jnp.asarray(v, float) for k, v in (SETTINGS | settings).items()})


def sampled(acceleration, rate, field=None):
    columns = [part for part in (acceleration, rate, field) if part is not None]
    return ImuSample(
        *(
            jnp.asarray(np.concatenate([part, np.repeat(part[-1:], N - len(part), axis=0)]))
            for part in columns
        )
    )


def filtered(filter, acceleration, rate, **settings):
    out = compiled(filter, noise(**settings), sampled(acceleration, rate))[1]
    return jax.tree.map(lambda leaf: np.asarray(leaf)[: len(rate)], out)


def turns(q):
    return Rotation.from_quat(q, scalar_first=True)


def quaternion(rotation):
    return rotation.as_quat(scalar_first=True)


def at_rest(rotation, bias=(0.0, 0.0, 0.0)):
    force = rotation.inv().apply([0.0, 0.0, GRAVITY])
    return np.tile(force, (N, 1)), np.tile(bias, (N, 1))


def apart(q, truth):
    """Total, heading and inclination in deg, ``(N,)`` each."""
    found = errors(jnp.asarray(q), jnp.asarray(np.broadcast_to(truth, np.shape(q))))
    return [np.degrees(part) for part in found]


# --------------------------------------------------------------------------------- the oracle


def skewed(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def textbook(acceleration, rate, adaptive, **settings):
    """Markley's error state: error rotation on the body's side, all three axes at once."""
    s = SETTINGS | settings
    attitude, b = turns(s["q0"]), np.array(s["b0"])
    P = np.diag([s["tilt0"] ** 2] * 3 + [s["bias0"] ** 2] * 3)
    Q = DT * np.diag([s["gyroscope"]] * 3 + [s["bias"]] * 3)
    r, keep = np.full(3, s["accelerometer"]), np.exp(-DT / s["memory"])
    rows = []
    for a, w in zip(acceleration / s["gravity"], rate, strict=True):
        turn = Rotation.from_rotvec((w - b) * DT)
        attitude = attitude * turn
        F = np.block([[turn.as_matrix().T, -DT * np.eye(3)], [np.zeros((3, 3)), np.eye(3)]])
        P = F @ P @ F.T + Q
        up = attitude.inv().apply([0.0, 0.0, 1.0])
        e = a - up
        detected = abs(a @ a - 1) > s["delta"]
        if adaptive:
            added = s["gain"] * np.abs(e) if detected else s["accelerometer"]
            r = keep * r + (1 - keep) * added
            if detected:
                r = np.maximum(r, s["accelerometer"])
        H = np.hstack([skewed(up), np.zeros((3, 3))])
        S = H @ P @ H.T + np.diag(r)
        K = P @ H.T @ np.linalg.inv(S)
        x, P = K @ e, (np.eye(6) - K @ H) @ P
        attitude, b = attitude * Rotation.from_rotvec(x[:3]), b + x[3:]
        rows.append((quaternion(attitude), b, r, detected, surprise(e, S)))
    return [np.array(column) for column in zip(*rows, strict=True)]


def shaken(rng, samples=100):
    """A sensor that turns at about 1 rad/s, with noise, disturbed in blocks of samples."""
    rate = np.cumsum(0.2 * rng.normal(size=(samples, 3)), axis=0)
    truth = Rotation.random(rng=rng)
    force = []
    for k in range(samples):
        truth = truth * Rotation.from_rotvec(DT * rate[k])
        force.append(truth.inv().apply([0.0, 0.0, GRAVITY]))
    force = np.array(force) + 0.05 * rng.normal(size=(samples, 3))
    force += 4.0 * rng.normal(size=(samples, 3)) * (np.arange(samples) // 10 % 3 == 1)[:, None]
    return force, rate + 0.02 * rng.normal(size=(samples, 3)) + [0.03, -0.02, 0.01], truth


@pytest.mark.parametrize("adaptive", [True, False])
@pytest.mark.parametrize("seed", [1, 2])
def test_is_the_textbooks_error_state_filter(adaptive, seed):
    force, rate, truth = shaken(np.random.default_rng(seed))
    settings = {"q0": quaternion(truth), "b0": np.array([0.01, 0.0, -0.01]), "accelerometer": 3e-3}
    q, b, r, detected, surprising = textbook(force, rate, adaptive, **settings)
    found = filtered(AttitudeKalman(DT, adaptive), force, rate, **settings)
    assert 20 < detected.sum() < 60
    np.testing.assert_array_equal(found.detected, detected)
    # a hundred samples' rounding, with one joint inverse in the textbook
    np.testing.assert_allclose(found.b, b, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.r, r, rtol=0, atol=1e-10)
    found_surprising = surprises(found.innovation, found.variance)
    # over variances of 3e-3
    np.testing.assert_allclose(found_surprising, surprising, rtol=0, atol=1e-8)
    sign = np.sign((found.att * q).sum(axis=1, keepdims=True))
    np.testing.assert_allclose(found.att * sign, q, rtol=0, atol=1e-10)


def test_without_adaptation_it_is_the_adaptive_filter_with_gain_zero():
    force, rate, _ = shaken(np.random.default_rng(3))
    plain, zero = filtered(PLAIN, force, rate), filtered(ADAPTIVE, force, rate, gain=0.0)
    for one, other in zip(plain, zero, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)
    adapted = filtered(ADAPTIVE, force, rate)
    assert np.abs(adapted.att - plain.att).max() > 1e-3


# --------------------------------------------------------------------------------- properties


@pytest.mark.parametrize("filter", [ADAPTIVE, PLAIN], ids=["adaptive", "plain"])
@pytest.mark.parametrize("angle", [-40.0, 75.0, 150.0])
def test_tilt_is_found_at_rest_from_a_wrong_start(filter, angle):
    truth = Rotation.from_rotvec(np.radians(angle) * np.array([0.6, 0.8, 0.0]))
    # Without a bias to be found the error goes as exp(-t/1.4 s) at the end; else the wrong start
    # goes into the bias too, and leaves it slowly.
    for bias0, left in ((0.0, 1e-3), (0.05, 0.2)):
        found = filtered(filter, *at_rest(truth), tilt0=2.0, bias0=bias0)
        _, _, inclination = apart(found.att, quaternion(truth))
        assert inclination[0] < abs(angle)
        assert inclination[-1] < left
        np.testing.assert_allclose(np.linalg.norm(found.att, axis=1), 1.0, rtol=1e-14)
        assert not found.detected.any()


def test_bias_is_found_at_rest_but_for_the_vertical():
    bias = np.array([0.02, -0.01, 0.03])
    found = filtered(PLAIN, *at_rest(Rotation.identity(), bias)).b[-1]
    np.testing.assert_allclose(found[:2], bias[:2], rtol=0, atol=1e-4)
    assert abs(found[2]) < 1e-5  # nothing tells it from a turn


def test_bias_is_found_in_motion_about_all_axes():
    motion = simulate(seconds=N * DT, dt=DT, seed=5, swing=Swing((0.6, 0.5, 0.8)))
    bias = (0.02, -0.01, 0.03)
    sample = measure(motion, gyroscope=Sensor(1e-3, bias), accelerometer=Sensor(0.05), seed=6)
    found = filtered(PLAIN, sample.acc, sample.gyr)
    np.testing.assert_allclose(found.b[-1], bias, rtol=0, atol=2e-3)
    # drift alone would be 40 s * 0.02 rad/s = 46 deg
    assert apart(found.att, motion.q)[2][N // 2 :].max() < 1.0


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.6, -0.8, 0.0)])
def test_full_turns_through_the_vertical_and_upside_down(axis):
    rate = np.tile(np.radians(90.0) * np.array(axis), (N, 1))
    truth = Rotation.from_rotvec(DT * np.arange(1, N + 1)[:, None] * rate)
    force = truth.inv().apply([0.0, 0.0, GRAVITY])
    wrong = quaternion(Rotation.from_rotvec([0.2, -0.1, 0.0]))
    for filter in (ADAPTIVE, PLAIN):
        found = filtered(filter, force, rate, q0=wrong)
        assert all(np.isfinite(column).all() for column in found)
        _, _, inclination = apart(found.att, quaternion(truth))
        assert inclination[0] > 0.05
        assert inclination[-1] < 0.01
    assert truth.inv().apply([0.0, 0.0, 1.0])[:, 2].min() < -0.999


def test_without_accelerometers_it_is_the_gyroscopes_alone():
    """And what was known of the bias stays."""
    rng = np.random.default_rng(8)
    rate, b0 = rng.normal(size=(100, 3)), np.array([0.1, -0.2, 0.3])
    found = filtered(ADAPTIVE, np.full((100, 3), np.nan), rate, b0=b0)
    attitude = Rotation.identity()
    for k in range(100):
        attitude = attitude * Rotation.from_rotvec(DT * (rate[k] - b0))
    # a hundred products
    np.testing.assert_allclose(apart(found.att[-1:], quaternion(attitude))[0], 0.0, atol=1e-11)
    np.testing.assert_array_equal(found.b, np.tile(b0, (100, 1)))
    np.testing.assert_allclose(found.r, SETTINGS["accelerometer"], rtol=1e-12)
    assert not found.detected.any()
    assert not found.innovation.any()
    assert not found.variance.any()


def test_one_missing_axis_leaves_the_others_in_use():
    truth = Rotation.from_rotvec([0.3, -0.2, 0.0])
    force, rate = at_rest(truth)
    force[:, 2] = np.nan
    found = filtered(ADAPTIVE, force, rate)
    assert apart(found.att, quaternion(truth))[2][-1] < 1e-3
    np.testing.assert_array_equal((found.variance > 0).all(axis=0), [True, True, False])
    assert not found.innovation[:, 2].any()


def test_variance_grows_along_the_axis_that_contradicts_the_gyroscopes():
    force, rate = at_rest(Rotation.identity())
    force[500:550, 1] += 4.0
    found = filtered(ADAPTIVE, force, rate)
    assert found.detected.sum() == 50
    grown = found.r[549] / SETTINGS["accelerometer"]
    assert grown[1] > 100
    assert grown[0] < 10
    # forgotten with the time constant: memory is 25 samples
    over = found.r[:, 1] - SETTINGS["accelerometer"]
    assert over[574] / over[549] == pytest.approx(np.exp(-1.0), rel=1e-9)


@pytest.mark.parametrize("seed", [1, 2])
def test_adaptation_helps_where_there_are_bursts(seed):
    motion = simulate(
        seconds=N * DT, dt=DT, seed=seed, swing=Swing((0.3, 0.3, 0.5)), bursts=Bursts(8, 5.0)
    )
    sample = measure(motion, gyroscope=Sensor(2e-3), accelerometer=Sensor(0.05), seed=seed)
    values = [
        float(rmse(filtered(filter, sample.acc, sample.gyr).att, motion.q))
        for filter in (ADAPTIVE, PLAIN)
    ]
    assert 0.2 < motion.disturbed.mean() < 0.6
    assert values[0] < 0.7 * values[1]


# ----------------------------------------------------------------------- Mahony and Madgwick


FIELD = np.array([0.0, 0.4, -0.9])  # earth y is north
TRUTH = Rotation.from_rotvec([0.5, -0.7, 1.1])
MAHONY = MahonyGains(*(jnp.asarray(v) for v in (2.0, 0.3, ONE)))
MADGWICK = MadgwickGain(jnp.asarray(0.2), jnp.asarray(ONE))
both = pytest.mark.parametrize(
    ("filter", "gains", "left"),
    # Mahony's error goes as e^-2t at the least, with a bias as e^-0.15t; Madgwick's steps have the
    # constant length beta dt = 0.004, half of an angle.
    [(Mahony(DT), MAHONY, 0.2), (Madgwick(DT), MADGWICK, np.degrees(0.016))],
    ids=["Mahony", "Madgwick"],
)


@both
def test_six_axes_find_the_inclination_at_rest(filter, gains, left):
    q = compiled(filter, gains, sampled(*at_rest(TRUTH)))[1]
    _, heading, inclination = apart(q, quaternion(TRUTH))
    assert inclination[0] > 30
    assert inclination[-200:].max() < left
    assert heading[-1] > 20  # nothing shows it
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, rtol=1e-14)


@both
def test_a_field_shows_the_heading(filter, gains, left):
    if isinstance(filter, Mahony):
        gains = gains._replace(Ki=jnp.asarray(0.0))  # no bias that winds up from a start 80 deg off
    field = np.tile(47.0 * TRUTH.inv().apply(FIELD), (N, 1))
    q = compiled(filter, gains, sampled(*at_rest(TRUTH), field))[1]
    total, heading, _ = apart(q, quaternion(TRUTH))
    assert heading[0] > 30
    assert total[-200:].max() < 2 * left
    # whatever the field's dip: only its horizontal direction counts
    dipped = np.tile(TRUTH.inv().apply([0.0, 0.6, 0.4]), (N, 1))
    q = compiled(filter, gains, sampled(*at_rest(TRUTH), dipped))[1]
    assert apart(q, quaternion(TRUTH))[0][-200:].max() < 2 * left


def test_mahony_finds_the_bias_at_rest():
    bias = np.array([0.02, -0.01, 0.0])
    gains = MAHONY._replace(q0=jnp.asarray(quaternion(Rotation.from_rotvec([0.2, 0.1, 0.0]))))
    state, q = compiled(Mahony(DT), gains, sampled(*at_rest(Rotation.identity(), bias)))
    # the slow root of s^2 + 2 s + 0.3 is 0.16/s: e^-6.5 after 40 s
    np.testing.assert_allclose(state.push, -bias, rtol=0, atol=1e-3)
    assert apart(q, ONE)[2][-1] < 0.1


stepped = jax.jit(
    lambda filter, gains, state, sample: filter.step(gains, state, sample),
    static_argnums=0,
)


def cost(q, a):
    """f_g and J_g of the paper, (25) and (26)."""
    w, x, y, z = q
    f = [2 * (x * z - w * y) - a[0], 2 * (w * x + y * z) - a[1], 2 * (0.5 - x**2 - y**2) - a[2]]
    J = [[-2 * y, 2 * z, -2 * w, 2 * x], [2 * x, 2 * w, 2 * z, 2 * y], [0, -4 * x, -4 * y, 0]]
    return np.array(f), np.array(J)


def field_cost(q, m, by, bz):
    """f_b and J_b, (29) and (30), for a field along (0, by, bz): the paper has north along x."""
    w, x, y, z = q
    f = [
        2 * by * (x * y + w * z) + 2 * bz * (x * z - w * y) - m[0],
        2 * by * (0.5 - x**2 - z**2) + 2 * bz * (w * x + y * z) - m[1],
        2 * by * (y * z - w * x) + 2 * bz * (0.5 - x**2 - y**2) - m[2],
    ]
    J = 2 * np.array(
        [
            [by * z - bz * y, by * y + bz * z, by * x - bz * w, by * w + bz * x],
            [bz * x, -2 * by * x + bz * w, bz * z, -2 * by * z + bz * y],
            [-by * x, -by * w - 2 * bz * x, by * z - 2 * bz * y, by * y],
        ]
    )
    return np.array(f), J


@given(rng=seeds())
def test_madgwicks_step_is_the_papers(rng):
    """q' = q w / 2 - beta J'f / |J'f|, with the paper's q as ours, w first.

    The paper calls its quaternion the earth's relative to the sensor, but turns vectors of the
    earth into the sensor by q* v q, as we do: nothing is to be conjugated.
    """
    turn, w = Rotation.random(rng=rng), rng.normal(size=3)
    q, (a, m) = quaternion(turn), rng.normal(size=(2, 3))
    gains = MadgwickGain(jnp.asarray(0.3), jnp.asarray(ONE))
    rates = np.concatenate([[-(q[1:] @ w)], q[0] * w + np.cross(q[1:], w)]) / 2
    f, J = cost(q, a / np.linalg.norm(a))
    slope = J.T @ f
    h = turn.apply(m / np.linalg.norm(m))
    f, J = field_cost(q, m / np.linalg.norm(m), np.hypot(h[0], h[1]), h[2])
    for sample, s in (
        (ImuSample(GRAVITY * a, w), slope),
        (ImuSample(GRAVITY * a, w, m), slope + J.T @ f),
    ):
        moved = q + DT * (rates - 0.3 * s / np.linalg.norm(s))
        _, found = stepped(Madgwick(DT), gains, q, sample)
        # a few roundings, over |J'f|, which is seldom below 0.1
        np.testing.assert_allclose(found, moved / np.linalg.norm(moved), rtol=0, atol=1e-13)


@given(rng=seeds())
def test_mahonys_step_is_the_papers(rng):
    """omega = gyroscopes + Kp e + the integral of Ki e, e = sum of measured x expected."""
    turn, w = Rotation.random(rng=rng), rng.normal(size=3)
    a, m, push = rng.normal(size=(3, 3))
    filter, gains = Mahony(DT), MAHONY
    state = filter.init(gains)._replace(q=quaternion(turn), push=push)
    north = turn.apply(m / np.linalg.norm(m))
    north = turn.inv().apply([0.0, np.hypot(north[0], north[1]), north[2]])
    gravity = np.cross(a / np.linalg.norm(a), turn.inv().apply([0.0, 0.0, 1.0]))
    both = gravity + np.cross(m / np.linalg.norm(m), north)
    for sample, e in ((ImuSample(a, w), gravity), (ImuSample(a, w, m), both)):
        pushed = push + 0.3 * DT * e
        expected = turn * Rotation.from_rotvec(DT * (w + 2.0 * e + pushed))
        after, found = stepped(filter, gains, state, sample)
        np.testing.assert_allclose(after.push, pushed, rtol=0, atol=1e-14)
        assert (turns(found).inv() * expected).magnitude() < 1e-14


@pytest.mark.parametrize("missing", [0.0, np.nan, np.inf])
@pytest.mark.parametrize("filter", [Mahony(DT), Madgwick(DT)], ids=["Mahony", "Madgwick"])
def test_without_a_direction_the_gyroscopes_turn_it_alone(filter, missing):
    """A force or a field that is missing, or that is zero and so has no direction."""
    rate, q = np.array([0.3, -0.2, 0.5]), quaternion(TRUTH)
    gains = MAHONY if isinstance(filter, Mahony) else MADGWICK
    state = filter.init(gains._replace(q0=jnp.asarray(q)))
    nothing = np.full(3, missing)
    _, alone = stepped(filter, gains, state, ImuSample(nothing, rate))
    expected = quaternion(TRUTH * Rotation.from_rotvec(DT * rate))
    # Madgwick's Euler step is wrong by 2 (w dt / 2)^3 / 3
    assert apart(np.asarray(alone)[None], expected)[0][0] < np.degrees(2e-7)
    _, with_field = stepped(filter, gains, state, ImuSample(nothing, rate, nothing))
    np.testing.assert_array_equal(with_field, alone)
    force = np.array([1.0, 2.0, 9.0])
    _, six = stepped(filter, gains, state, ImuSample(force, rate))
    _, nine = stepped(filter, gains, state, ImuSample(force, rate, nothing))
    np.testing.assert_allclose(nine, six, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("filter", "params"),
    [(Mahony(DT), MahonyGains(1.0, 0.1, ONE)), (Madgwick(DT), MadgwickGain(0.1, ONE))],
    ids=["Mahony", "Madgwick"],
)
def test_complementary_filters_run_in_single_precision(filter, params):
    """As on a small machine; the difference is float32's."""
    draw = np.random.default_rng(0).normal(size=(3, 9, 3))
    given = params, ImuSample(*draw)
    wide = compiled(filter, *jax.tree.map(jnp.asarray, given))
    narrow = compiled(filter, *jax.tree.map(lambda v: jnp.asarray(v, jnp.float32), given))
    assert narrow[1].dtype == jnp.float32
    np.testing.assert_allclose(narrow[1], wide[1], rtol=0, atol=1e-5)


@pytest.mark.parametrize("axes", [[0, 1, 2], [1]], ids=["all", "one"])
@pytest.mark.parametrize("filter", ["gravity", "Mahony", "Madgwick"])
def test_a_missing_rate_is_no_turn(filter, axes):
    """The same as a rate that is all bias, as far as the filter knows the bias."""
    bias, q = np.array([0.02, -0.01, 0.03]), jnp.asarray(quaternion(TRUTH))
    filter, params, state, still = {
        "gravity": (PLAIN, noise(), PLAIN.init(noise())._replace(q=q, b=jnp.asarray(bias)), bias),
        "Mahony": (
            Mahony(DT),
            MAHONY._replace(Ki=jnp.zeros(())),
            MahonyState(q, -jnp.asarray(bias)),
            bias,
        ),
        "Madgwick": (Madgwick(DT), MADGWICK, q, np.zeros(3)),
    }[filter]
    a = jnp.asarray(GRAVITY * np.array([0.1, 0.2, 0.9]))
    rest, gone = (np.array([0.3, -0.2, 0.5]) for _ in range(2))
    rest[axes], gone[axes] = still[axes], np.nan
    expected = filter.step(params, state, ImuSample(a, jnp.asarray(rest)))
    found = filter.step(params, state, ImuSample(a, jnp.asarray(gone)))
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_array_equal(one, other)
        assert np.isfinite(one).all()


def test_an_infinite_acceleration_is_missing():
    state = PLAIN.init(noise())
    rate = jnp.array([0.0, 0.0, 0.1])
    for a in ([np.inf, 0.0, 0.0], [-np.inf, np.inf, 1.0]):
        after, _ = PLAIN.step(noise(), state, ImuSample(jnp.array(a), rate))
        assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(after))


def test_madgwick_makes_no_step_where_no_error_is_left():
    """Rounding has no direction: without the guard it would be a step of full length."""
    turned = Rotation.from_rotvec([0.3, -0.5, 0.2])
    start = jnp.asarray(np.roll(turned.as_quat(), 1))
    force = np.tile(9.81 * turned.inv().apply([0.0, 0.0, 1.0]), (5, 1))
    inputs = ImuSample(jnp.asarray(force), jnp.zeros((5, 3)))
    _, found = run(Madgwick(0.02), MadgwickGain(jnp.asarray(0.12), start), inputs)
    assert np.abs(np.asarray(found[0]) - np.asarray(start)).max() < 1e-3 * 0.02 * 0.12
