"""The vertical channel against a textbook loop with matrices, and the Riccati equation."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg

from filters import Timed, TimedSample, Vertical, VerticalNoise, VerticalSample, run
from tests.oracles import kalman_predict, kalman_update

compiled = jax.jit(run, static_argnums=0)
N = 60
NOISE = VerticalNoise(*map(jnp.array, (0.05, 0.002, 0.3, 0.8, 0.4)))


def record(seed=5):
    rng = np.random.default_rng(seed)
    acc, baro = rng.normal(size=N), 300 + rng.normal(size=N)
    baro[np.arange(N) % 5 != 2] = np.nan
    acc[[0, 10, 11, 30]] = np.nan
    return acc, baro, rng.uniform(0.05, 0.4, N)


def moves(dt, noise=NOISE):
    """F, what an acceleration adds, and both noises: white on climb's rate, and on the offset's."""
    F = np.array([[1, dt, -(dt**2) / 2], [0, 1, -dt], [0, 0, 1]])
    push = np.array([dt**2 / 2, dt, 0])
    left = (np.arange(4000) + 0.5) / 4000 * dt  # the time that a piece of noise has to act
    white = np.array([left, np.ones(4000), np.zeros(4000)])
    walk = np.array([-(left**2) / 2, -left, np.ones(4000)])
    W = float(noise.q_acc) * white @ white.T + float(noise.q_bias) * walk @ walk.T
    return F, push, W * dt / 4000


def textbook(acc, baro, dt):
    """Height by the first barometer sample, with its variance; the acceleration before moves."""
    h, R = np.eye(3)[:1], np.array([[float(NOISE.R_baro)]])
    x = P = None
    last, rows, innovations = 0.0, np.zeros((N, 3)), np.zeros((N, 2))
    for k in range(N):
        if x is not None:
            F, push, W = moves(dt[k])
            x, P = kalman_predict(x, P, F, W)
            x = x + push * last
            if not np.isnan(baro[k]):
                innovations[k] = baro[k] - x[0], P[0, 0] + R[0, 0]
                x, P = kalman_update(x, P, h, R, baro[k : k + 1])
        elif not np.isnan(baro[k]):
            x = np.array([baro[k], 0, 0])
            P = np.diag([R[0, 0], float(NOISE.climb0) ** 2, float(NOISE.bias0) ** 2])
        last = last if np.isnan(acc[k]) else acc[k]
        rows[k] = 0 if x is None else x
    return rows, innovations


def test_it_is_the_textbook_loop():
    acc, baro, dt = record()
    inputs = TimedSample(jnp.asarray(dt), VerticalSample(jnp.asarray(acc), jnp.asarray(baro)))
    out = compiled(Timed(Vertical(1.0)), NOISE, inputs)[1]
    rows, innovations = textbook(acc, baro, dt)
    # The grid of moves leaves 1e-8 of W.
    np.testing.assert_allclose(np.stack(out[:3], axis=1), rows, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(out.innovation[:, 0], innovations[:, 0], rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(out.variance[:, 0], innovations[:, 1], rtol=1e-7)


def test_gravity_may_be_included():
    acc, baro, _ = record()
    removed = compiled(Vertical(0.1), NOISE, VerticalSample(jnp.asarray(acc), jnp.asarray(baro)))
    with_it = VerticalSample(jnp.asarray(acc + 9.80665), jnp.asarray(baro))
    included = compiled(Vertical(0.1, "included"), NOISE, with_it)
    np.testing.assert_allclose(removed[1].climb, included[1].climb, atol=1e-12)


def test_an_offset_is_found_and_leaves_no_climb():
    rng = np.random.default_rng(8)
    samples, dt = 6000, 0.02
    acc = 0.3 + 0.2 * rng.normal(size=samples)
    baro = np.where(np.arange(samples) % 5 == 0, 431 + 0.3 * rng.normal(size=samples), np.nan)
    noise = VerticalNoise(jnp.array(0.2**2 * dt), jnp.array(1e-8), jnp.array(0.09))
    out = compiled(Vertical(dt), noise, VerticalSample(jnp.asarray(acc), jnp.asarray(baro)))[1]
    # Two minutes of such a barometer tell the offset within 1e-3 m/s^2, and the climb within 0.05.
    assert float(out.bias[-1]) == pytest.approx(0.3, abs=4e-3)
    assert float(np.abs(np.asarray(out.climb)[-1000:]).mean()) < 0.1


@pytest.mark.parametrize("dt", [0.02, 1.0])
def test_the_steady_gains_solve_the_riccati_equation(dt):
    F, _, W = moves(dt)
    M = scipy.linalg.solve_discrete_are(F.T, np.eye(3)[:, :1], W, np.array([[0.3]]))
    derived = Vertical(dt).derive(NOISE)
    np.testing.assert_allclose(derived["Q"], W, rtol=1e-6)  # the grid's error
    np.testing.assert_allclose(derived["K"], M[:, 0] / (M[0, 0] + 0.3), rtol=1e-6)
    assert derived.keys() == Vertical.derived.keys()


def test_single_precision_stays_single_and_follows():
    acc, baro, _ = record()
    inputs = VerticalSample(jnp.asarray(acc), jnp.asarray(baro))
    whole = compiled(Vertical(0.02), NOISE, inputs)[1]
    single = jax.tree.map(lambda leaf: leaf.astype(np.float32), (NOISE, inputs))
    state, half = compiled(Vertical(0.02), *single)
    leaves = jax.tree.leaves((state, half, Vertical(0.02).derive(single[0])))
    assert {leaf.dtype for leaf in leaves} == {jnp.dtype("float32")}
    np.testing.assert_allclose(half.climb, whole.climb, atol=1e-3)  # 300 m has steps of 3e-5 m
