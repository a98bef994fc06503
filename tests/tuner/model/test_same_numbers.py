"""Filters of documents against the catalogue's, and against textbook loops in NumPy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg

from filters import (
    ConstantVelocity,
    ConstantVelocityNoise,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    LevelSample,
    LocalLevel,
    LocalLevelNoise,
    PositionSample,
    Timed,
    TimedSample,
    UnscentedKalman,
    Vertical,
    VerticalNoise,
    VerticalSample,
    run,
)
from tests.oracles import kalman_predict, kalman_update
from tests.tuner.model.documents import (
    COMPASS,
    GPS,
    OSCILLATOR,
    ROBOT,
    SHORT,
    VERTICAL,
    made,
    of_kind,
)

N = 60
compiled = jax.jit(run, static_argnums=0)


def walk(seed=1, missing=(0, 5, 20)):
    z = np.cumsum(np.random.default_rng(seed).normal(size=N))
    z[list(missing)] = np.nan
    return z


def uneven(seed=2):
    return np.random.default_rng(seed).choice([0.1, 0.0, 0.25, 1.7], N)


def through(cls, params, inputs, dt):
    """The outputs at one sample time, or at those of an array."""
    if np.ndim(dt):
        return compiled(Timed(cls(1.0)), params, TimedSample(jnp.asarray(dt), inputs))[1]
    return compiled(cls(dt), params, inputs)[1]


def close(one, other, tolerance=1e-12):
    scale = max(1.0, float(np.abs(other).max()))
    np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * scale)


def numbers(**given):
    return {name: jnp.array(value) for name, value in given.items()}


@pytest.mark.parametrize("dt", [0.1, uneven()], ids=["even", "uneven"])
@pytest.mark.parametrize("text", [SHORT, None], ids=["short", "template"])
def test_a_local_level(dt, text):
    level = of_kind("level") if text is None else made(text)
    z = jnp.asarray(walk())
    ours = through(level, level.params(**numbers(q=0.3, R=2.0)), level.inputs(z), dt)
    noise = LocalLevelNoise(jnp.array(0.3), jnp.array(2.0))
    theirs = through(LocalLevel, noise, LevelSample(z), dt)
    for name in ("level", "innovation", "variance"):
        close(getattr(ours, name), getattr(theirs, name))


@pytest.mark.parametrize("dt", [0.1, uneven()], ids=["even", "uneven"])
def test_constant_velocity(dt):
    tracking = of_kind("tracking")
    z = jnp.asarray(walk())
    ours = through(tracking, tracking.params(**numbers(q=0.3, R=2.0)), tracking.inputs(z), dt)
    noise = ConstantVelocityNoise(jnp.array(0.3), jnp.array(2.0))
    theirs = through(ConstantVelocity, noise, PositionSample(z), dt)
    close(ours.position, theirs.position[:, 0])
    close(ours.velocity, theirs.velocity[:, 0])
    close(ours.innovation, theirs.innovation)
    close(ours.variance, theirs.variance)


def test_noise_that_a_channel_tells():
    """And where it tells nothing, or 0, there is no measurement."""
    track, dt = made(GPS), uneven()
    x, y, rng = walk(3), walk(4), np.random.default_rng(5)
    sigma = rng.uniform(1, 4, N)
    sigma[[7, 9]] = np.nan, 0.0
    both = np.stack([x, y], axis=1)
    inputs = track.inputs(accuracy=jnp.asarray(sigma), gps=jnp.asarray(both))
    ours = through(track, track.params(**numbers(q=0.3, s=0.7)), inputs, dt)
    noise = ConstantVelocityNoise(jnp.array(0.3), jnp.array(0.49))
    sample = PositionSample(*map(jnp.asarray, (x, y)), sigma=jnp.asarray(sigma))

    def along(dt):
        return ConstantVelocity(dt, "xy")

    theirs = through(along, noise, sample, dt)
    close(jnp.stack([ours.x, ours.y], axis=1), theirs.position)
    close(ours.innovation, theirs.innovation)
    close(ours.variance, theirs.variance)


def test_a_known_input_stays_until_the_next():
    """P0 is that of a sample time before the first: here of none, as of the catalogue's filter."""
    vertical, dt = made(VERTICAL), np.concatenate([[0.0], uneven()[1:]])
    baro, acc = walk(6, missing=(5, 20)), np.random.default_rng(7).normal(size=N)
    acc[[10, 11]] = np.nan
    inputs = vertical.inputs(acc=jnp.asarray(acc), baro=jnp.asarray(baro))
    values = numbers(q_acc=0.05, q_bias=0.002, R_baro=0.3)
    ours = through(vertical, vertical.params(**values), inputs, dt)
    theirs = through(Vertical, VerticalNoise(**values), VerticalSample(*inputs), dt)
    for name in ("height", "climb", "bias", "innovation", "variance"):
        close(getattr(ours, name), getattr(theirs, name))


def textbook(z, u, dt, values, A):
    """An oscillator by matrix exponentials of the whole, and updates by a solve."""
    q, r = values["q"], values["r"]
    H, R = np.array([[1, 0.2], [0.5, 1]]), r * np.array([[1, 0.4], [0.4, 2.0]])
    x, P, rows = np.array([0.1, -0.2]), np.array([[1, 0.2], [0.2, 0.5]]), []
    last = 0.0
    for k in range(N):
        big = np.zeros((5, 5))
        big[:2, :2], big[:2, 2:4], big[2:4, 2:4] = -A, np.diag([0.0, q]), A.T
        both = scipy.linalg.expm(big[:4, :4] * dt[k])
        F = both[2:, 2:].T
        beside = np.block([[A, np.array([[0], [1.0]])], [np.zeros((1, 3))]])
        pushed = scipy.linalg.expm(beside * dt[k])
        x, P = kalman_predict(x, P, F, F @ both[:2, 2:])
        x = x + pushed[:2, 2] * last
        x, P = kalman_update(x, P, H, R, z[k])
        last = last if np.isnan(u[k]) else u[k]
        rows.append((x, P))
    return np.array([x for x, _ in rows]), np.array([P for _, P in rows])


@pytest.mark.parametrize("dt", [0.1, uneven()], ids=["even", "uneven"])
def test_an_oscillator_with_shared_noise(dt):
    oscillator, rng = made(OSCILLATOR), np.random.default_rng(8)
    z, u = rng.normal(size=(N, 2)), rng.normal(size=N)
    z[[3, 8], 0], z[[8, 9], 1], u[4] = np.nan, np.nan, np.nan
    values = {"omega": 3.0, "damping": 0.1, "q": 0.5, "r": 0.3}
    A = np.array([[0, 1], [-9.0, -0.6]])
    inputs = oscillator.inputs(*map(jnp.asarray, (u, z[:, 0], z[:, 1])))
    ours = through(oscillator, oscillator.params(**numbers(**values)), inputs, dt)
    x, P = textbook(z, u, np.broadcast_to(dt, N), values, A)
    close(np.stack([ours.x, ours.v], axis=1), x)
    close(ours.P, P)


def python_robot(p, x, u):
    return x + p[2] * jnp.stack([u[0] * jnp.cos(x[2]), u[0] * jnp.sin(x[2]), u[1]])


def python_noise(p, x, u):
    c, s = jnp.cos(x[2]), jnp.sin(x[2])
    G = jnp.stack([jnp.stack([c, 0 * c]), jnp.stack([s, 0 * c]), jnp.array([0.0, 1.0])])
    return (G * p[:2] * p[2]) @ G.T


def python_seen(p, x, u):
    return x[:2]


@pytest.mark.parametrize("method", ["extended", "iterated", "unscented"])
def test_a_robot_in_python(method):
    """The same filter from a document and from functions of one's own."""
    robot, rng = made(f'method = "{method}"\n{ROBOT}'), np.random.default_rng(9)
    u = rng.normal(size=(N, 2))
    z = np.where(np.arange(N)[:, None] % 4 == 1, np.cumsum(rng.normal(size=(N, 2)), axis=0), np.nan)
    inputs = robot.inputs(*map(jnp.asarray, (u[:, 0], u[:, 1], z)))
    params = robot.params(**numbers(q_speed=0.2, q_turn=0.05, R=0.7))
    ours = compiled(robot(0.1), params, inputs)[1]
    functions = python_robot, python_noise, python_seen
    filter = {
        "extended": ExtendedKalman(*functions),
        "iterated": ExtendedKalman(*functions, iterations=5),
        "unscented": UnscentedKalman(*functions, turning=(False, False, True)),
    }[method]
    P0 = jnp.diag(jnp.array([25.0, 25, 10]))
    model = ExtendedModel(jnp.array([0.2, 0.05, 0.1]), 0.7 * jnp.ones(2), jnp.zeros(3), P0)
    before = np.vstack([np.zeros((1, 2)), u[:-1]])
    theirs = compiled(filter, model, ExtendedSample(jnp.asarray(z), jnp.asarray(before)))[1]
    close(np.stack([ours.x, ours.y, ours.heading], axis=1), theirs.x)
    for name in ("P", "innovation", "variance"):
        close(getattr(ours, name), getattr(theirs, name))


def pendulum_loop(z, dt, q, R, friction):
    """Fine steps of Euler for state, transition and noise: nothing shared, first order."""
    x, P, rows, pieces = np.array([0.5, 0.0]), np.diag([0.1, 0.5]), [], 4000
    for k in range(len(z)):
        h, F, Q = dt / pieces, np.eye(2), np.zeros((2, 2))
        for _ in range(pieces):
            A = np.array([[0, 1], [-9.80665 * np.cos(x[0]), -friction]])
            step = np.eye(2) + h * A
            Q = step @ Q @ step.T + h * np.diag([0.0, q])
            F = step @ F
            x = x + h * np.array([x[1], -9.80665 * np.sin(x[0]) - friction * x[1]])
        P = F @ P @ F.T + Q
        if not np.isnan(z[k]):
            H = np.array([[np.sin(x[0]), 0.0]])
            S = (H @ P @ H.T)[0, 0] + R
            K = P @ H[0] / S
            x, P = x + K * (z[k] - (1 - np.cos(x[0]))), P - np.outer(K, K) * S
        rows.append(x)
    return np.array(rows)


def test_a_pendulum_is_that_of_fine_steps():
    """Runge and Kutta at dt against steps so fine that their own error is 1e-4."""
    pendulum, dt, n = of_kind("pendulum"), 0.05, 12
    z = 0.1 + 0.05 * np.random.default_rng(10).normal(size=n)
    z[4] = np.nan
    params = pendulum.params(**numbers(q=0.1, R=0.01, friction=0.2, length=1.0, gravity=9.80665))
    ours = compiled(pendulum(dt), params, pendulum.inputs(jnp.asarray(z)))[1]
    theirs = pendulum_loop(z, dt, 0.1, 0.01, 0.2)
    np.testing.assert_allclose(np.stack([ours.angle, ours.rate], axis=1), theirs, atol=1e-4)


def test_the_order_of_its_steps_is_four():
    pendulum = of_kind("pendulum")
    params = pendulum.params(**numbers(q=0.1, R=0.01, friction=0.2, length=1.0, gravity=9.80665))

    def at_end(dt):
        z = jnp.full(round(1.6 / dt), jnp.nan)
        out = compiled(pendulum(dt), params, pendulum.inputs(z))[1]
        return np.concatenate([[out.angle[-1], out.rate[-1]], out.P[-1].ravel()])

    exact = at_end(0.0125)
    errors = [np.abs(at_end(dt) - exact).max() for dt in (0.2, 0.1)]
    assert 2.0**3.5 < errors[0] / errors[1] < 2.0**4.8


def test_an_angle_is_measured_within_half_a_turn():
    compass, rng = made(COMPASS), np.random.default_rng(11)
    true = 3.0 + np.cumsum(0.1 * rng.normal(size=N))
    z = true + 0.1 * rng.normal(size=N)
    params = compass.params(**numbers(q=0.1, R=0.01))
    plain, wrapped = (
        compiled(compass(0.5), params, compass.inputs(jnp.asarray(each)))[1]
        for each in (z, (z + np.pi) % (2 * np.pi) - np.pi)
    )
    assert np.abs(wrapped.innovation).max() < np.pi
    close(plain.rate, wrapped.rate)
    turns = (np.asarray(plain.heading) - np.asarray(wrapped.heading)) / (2 * np.pi)
    close(turns, np.round(turns), 1e-10)


@pytest.mark.parametrize("method", ["iterated", "unscented"])
def test_a_linear_model_is_the_same_by_every_method(method):
    """With noise that measurements share, and none of them linearised."""
    kalman, other = made(OSCILLATOR), made(f'method = "{method}"\n{OSCILLATOR}')
    rng = np.random.default_rng(12)
    z, u = rng.normal(size=(N, 2)), rng.normal(size=N)
    z[[3, 8], 0] = np.nan
    inputs = kalman.inputs(*map(jnp.asarray, (u, z[:, 0], z[:, 1])))
    params = kalman.params(**numbers(omega=3.0, damping=0.1, q=0.5, r=0.3))
    ours = compiled(other(0.1), other.params(*params), other.inputs(*inputs))[1]
    theirs = compiled(kalman(0.1), params, inputs)[1]
    for one, same in zip(ours, theirs, strict=True):
        close(one, same, 1e-10)
