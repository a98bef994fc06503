"""The extended Kalman filter against a textbook loop and, on a linear model, LinearKalman."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given

from filters import (
    Estimate,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
    linearised,
    run,
)
from tests.oracles import kalman_update
from tests.strategies import seeds

N, DT = 40, 0.1
compiled = jax.jit(run, static_argnums=0)


# A driven pendulum, x = (angle, rate), p = (omega^2, friction, q), seen from the side.


def swung(p, x, u):
    return jnp.stack([x[0] + DT * x[1], x[1] + DT * (u - p[0] * jnp.sin(x[0]) - p[1] * x[1])])


def shaken(p, x, u):
    # as much more noise as it is further from rest: at which state Q is taken matters
    return p[2] * (1 + x[0] ** 2) * jnp.array([[1e-3, 1e-2], [1e-2, 0.2]])


def seen(p, x, u):
    return jnp.stack([jnp.sin(x[0]), x[1] + 0.1 * u * jnp.cos(x[0])])


def textbook(p, R, x, P, z, u):
    """x-, P- and then all measurements that there are at once, by an inverse."""
    omega, friction, q = p
    R, xs, Ps = np.diag(R), [], []
    for k in range(len(z)):
        F = np.array([[1.0, DT], [-DT * omega * np.cos(x[0]), 1 - DT * friction]])
        Q = q * (1 + x[0] ** 2) * np.array([[1e-3, 1e-2], [1e-2, 0.2]])
        push = u[k] - omega * np.sin(x[0]) - friction * x[1]
        x, P = x + DT * np.array([x[1], push]), F @ P @ F.T + Q
        H = np.array([[np.cos(x[0]), 0.0], [-0.1 * u[k] * np.sin(x[0]), 1.0]])
        h = np.array([np.sin(x[0]), x[1] + 0.1 * u[k] * np.cos(x[0])])
        there = ~np.isnan(z[k])
        H, S = H[there], R[np.ix_(there, there)]
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + S)
        x = x + K @ (z[k] - h)[there]
        P = (np.eye(2) - K @ H) @ P
        xs.append(x)
        Ps.append(P)
    return np.array(xs), np.array(Ps)


@given(rng=seeds())
def test_is_the_textbooks_filter_at_two_rates(rng):
    p, R = np.exp(rng.normal(size=3)), np.exp(rng.normal(size=2))
    x0, u = 0.5 * rng.normal(size=2), rng.normal(size=N)
    root = 0.5 * rng.normal(size=(2, 2))
    z = rng.normal(size=(N, 2))
    z[np.arange(N) % 4 != 0, 1] = np.nan  # a slow sensor
    z[rng.uniform(size=N) < 0.2, 0] = np.nan  # and one with holes
    model = ExtendedModel(*(jnp.asarray(part) for part in (p, R, x0, root @ root.T)))
    inputs = ExtendedSample(jnp.asarray(z), jnp.asarray(u))
    (last, out) = compiled(ExtendedKalman(swung, shaken, seen), model, inputs)
    x, P = textbook(p, R, x0, root @ root.T, z, u)
    # rounding passes through 40 samples of a pendulum that may fall: digits go with its growth
    scale = max(1.0, np.abs(x).max())
    np.testing.assert_allclose(out.x, x, rtol=0, atol=1e-10 * scale)
    np.testing.assert_allclose(out.P, P, rtol=0, atol=1e-10 * np.abs(P).max())
    np.testing.assert_array_equal(last.x, out.x[-1])
    np.testing.assert_array_equal(np.asarray(out.gain)[np.isnan(z)], 0.0)
    np.testing.assert_array_equal(np.asarray(out.innovation)[np.isnan(z)], 0.0)
    np.testing.assert_array_equal(np.asarray(out.variance) == 0, np.isnan(z))


def moved(p, x, u):
    return p.transition.F @ x + p.transition.B @ u


def disturbed(p, x, u):
    return p.transition.G @ p.transition.Q @ p.transition.G.T


def measured(p, x, u):
    return p.H @ x


@cache
def linear():
    rng = np.random.default_rng(1960)
    F = rng.normal(size=(3, 3))
    move = Transition(
        F=0.95 * F / np.abs(np.linalg.eigvals(F)).max(),
        G=rng.normal(size=(3, 2)),
        Q=np.diag([0.3, 0.7]),
        B=rng.normal(size=(3, 1)),
    )
    model = LinearModel(
        move, rng.normal(size=(2, 3)), np.array([0.5, 2.0]), np.eye(3), rng.normal(size=3)
    )
    return jax.tree.map(jnp.asarray, model)


@pytest.mark.parametrize("holes", [False, True], ids=["whole", "holes"])
def test_of_a_linear_model_is_the_linear_filter(holes):
    rng = np.random.default_rng(7)
    z, u = rng.normal(size=(N, 2)), jnp.asarray(rng.normal(size=(N, 1)))
    if holes:
        z[rng.uniform(size=(N, 2)) < 0.4] = np.nan
    model = linear()
    plain = compiled(LinearKalman(), model, Sample(jnp.asarray(z), u=u))
    extended = compiled(
        ExtendedKalman(moved, disturbed, measured),
        ExtendedModel(model, model.R, model.x0, model.P0),
        ExtendedSample(jnp.asarray(z), u),
    )
    for one, other in zip(jax.tree.leaves(extended), jax.tree.leaves(plain), strict=True):
        scale = np.abs(np.asarray(other)).max()
        # the innovation goes through z - h(x) + H x: a few units in the last place a sample
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * scale)


update = jax.jit(linearised)


@given(rng=seeds())
def test_linearised_measurements_are_one_joint_update(rng):
    """Although they are taken one after another: all of them at the prediction's slope."""
    root, x = rng.normal(size=(3, 3)), rng.normal(size=3)
    H, z, expected = rng.normal(size=(4, 3)), rng.normal(size=4), rng.normal(size=4)
    z[rng.integers(4)] = np.nan
    R, P = np.exp(rng.normal(size=4)), root @ root.T
    found, outputs = update(Estimate(x, P), H, R, z, expected)
    # the oracle's measurements are H x + v
    known, spread = kalman_update(x, P, H, np.diag(R), z - expected + H @ x)
    np.testing.assert_allclose(found.x, known, rtol=0, atol=1e-12 * (1 + np.abs(known).max()))
    np.testing.assert_allclose(found.P, spread, rtol=0, atol=1e-12 * np.abs(P).max())
    first = 0 if not np.isnan(z[0]) else 1
    assert float(outputs.innovation[first]) == pytest.approx(
        z[first] - expected[first] + (H[first] @ x - H[first] @ x), abs=1e-12
    )


def test_without_measurements_it_is_the_model():
    p, x = np.array([4.0, 0.3, 1.0]), np.array([2.5, -1.0])
    u = np.sin(np.arange(N))
    model = ExtendedModel(jnp.asarray(p), jnp.ones(2), jnp.asarray(x), jnp.eye(2))
    inputs = ExtendedSample(jnp.full((N, 2), jnp.nan), jnp.asarray(u))
    out = compiled(ExtendedKalman(swung, shaken, seen), model, inputs)[1]
    for k in range(N):
        x = np.array([x[0] + DT * x[1], x[1] + DT * (u[k] - p[0] * np.sin(x[0]) - p[1] * x[1])])
        # each sample's own rounding, and what the pendulum makes of the ones before
        np.testing.assert_allclose(out.x[k], x, rtol=0, atol=1e-12)
