"""The iterated update and measured angles of the extended filter, against textbook loops."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given

from filters import ExtendedKalman, ExtendedModel, ExtendedSample, run
from filters.angles import difference, wrapped
from tests.strategies import covariance, seeds

N = 25
compiled = jax.jit(run, static_argnums=0)


# A vessel of constant velocity past two masts: bearings of both and the range to the first.


def drifted(p, x, u):
    return jnp.stack([x[0] + 0.5 * x[2] + u, x[1] + 0.5 * x[3], x[2], x[3]])


def pushed(p, x, u):
    return p * jnp.diag(jnp.array([0.01, 0.01, 0.1, 0.1]))


def sighted(p, x, u):
    first = jnp.arctan2(x[1], x[0])
    second = jnp.arctan2(x[1] - 3.0, x[0] + 2.0)
    return jnp.stack([first, second, jnp.sqrt(x[0] ** 2 + x[1] ** 2)])


ANGLES = (True, True, False)


def seen(x):
    """h and its Jacobian."""
    a, b = x[0], x[1]
    c, d = x[0] + 2.0, x[1] - 3.0
    near, far = a**2 + b**2, c**2 + d**2
    h = np.array([np.arctan2(b, a), np.arctan2(d, c), np.sqrt(near)])
    H = np.zeros((3, 4))
    H[:, :2] = [[-b / near, a / near], [-d / far, c / far], [a / h[2], b / h[2]]]
    return h, H


def within(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def iterated(q, R, x, P, z, u, times):
    """Bell and Cathey 1993: Gauss-Newton from the prediction, all measurements at once."""
    F = np.eye(4) + 0.5 * np.eye(4, k=2)
    Q, xs, Ps, predicted = q * np.diag([0.01, 0.01, 0.1, 0.1]), [], [], []
    for k in range(len(z)):
        ahead, P = F @ x + np.array([u[k], 0, 0, 0]), F @ P @ F.T + Q
        there, x = ~np.isnan(z[k]), ahead
        for turn in range(times):
            h, H = seen(x)
            y = z[k] - h
            y[:2] = within(y[:2])
            H, y = H[there], y[there]
            S = H @ P @ H.T + np.diag(R[there])
            if turn == 0:
                predicted.append(y @ np.linalg.solve(S, y) + np.log(np.linalg.det(S)))
            K = P @ H.T @ np.linalg.inv(S)
            x = ahead + K @ (y - H @ (ahead - x))
        P = (np.eye(4) - K @ H) @ P
        xs.append(x)
        Ps.append(P)
    return np.array(xs), np.array(Ps), np.array(predicted)


def drawn(rng):
    """A vessel that crosses the line of half a turn of the first bearing, and what is sighted."""
    q, R = np.exp(rng.normal() - 2), np.exp(rng.normal(size=3) - 4)
    x0, u = np.array([-4.0, 2.0, 0.1, -0.3]), 0.05 * rng.normal(size=N)
    x, z = x0 + 0.2 * rng.normal(size=4), []
    for push in u:
        x = x + np.array([0.5 * x[2] + push, 0.5 * x[3], 0, 0])
        z.append(seen(x)[0] + np.sqrt(R) * rng.normal(size=3))
    z = np.array(z)
    z[:, :2] += 2 * np.pi * rng.integers(-1, 2, size=(N, 2))  # whatever turn is told
    z[rng.uniform(size=(N, 3)) < 0.2] = np.nan
    return q, R, x0, 0.04 * covariance(rng, 4, rng.integers(0, 5)), z, u


@given(rng=seeds())
@pytest.mark.parametrize("times", [1, 2, 5])
def test_is_gauss_newtons_textbook_loop(times, rng):
    q, R, x0, P0, z, u = drawn(rng)
    model = ExtendedModel(*(jnp.asarray(part) for part in (q, R, x0, P0)))
    inputs = ExtendedSample(jnp.asarray(z), jnp.asarray(u))
    filter = ExtendedKalman(drifted, pushed, sighted, iterations=times, angles=ANGLES)
    out = compiled(filter, model, inputs)[1]
    x, P, predicted = iterated(q, R, x0, P0, z, u, times)
    np.testing.assert_allclose(out.x, x, rtol=0, atol=1e-10 * max(1.0, np.abs(x).max()))
    np.testing.assert_allclose(out.P, P, rtol=0, atol=1e-10 * np.abs(P).max())
    # One after another they have the density of all together, of the first linearisation.
    there = ~np.isnan(z)
    variance = np.where(there, out.variance, 1.0)
    density = (np.asarray(out.innovation) ** 2 / variance + np.log(variance)).sum(axis=1)
    np.testing.assert_allclose(density, predicted, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(np.asarray(out.gain)[~there], 0.0)
    np.testing.assert_array_equal(np.asarray(out.variance) == 0, ~there)


def test_more_turns_end_at_the_state_of_greatest_density():
    """One update of a wide prior by one close range: Gauss-Newton's end has no slope."""
    x0, P0, R = jnp.array([1.0, 1.0, 0.0, 0.0]), jnp.eye(4), jnp.array([0.01, 0.01, 0.02])
    still = ExtendedModel(jnp.asarray(0.0), R, x0, P0)
    z = jnp.array([[0.9, jnp.nan, 2.5]])

    def cost(x):
        off = difference(z[0], sighted(None, x, 0.0), ANGLES)[jnp.array([0, 2])]
        return (off**2 / R[jnp.array([0, 2])]).sum() + ((x - x0) ** 2).sum()

    slopes = []
    for times in (1, 3, 20):
        filter = ExtendedKalman(lambda p, x, u: x, pushed, sighted, (), times, ANGLES)
        x = compiled(filter, still, ExtendedSample(z, jnp.zeros(1)))[1].x[0]
        slopes.append(float(jnp.abs(jax.grad(cost)(x)).max()))
    assert slopes[0] > 10 * slopes[1] > 0
    assert slopes[2] < 1e-9


def test_one_turn_without_angles_is_compiled_as_if_there_were_neither():
    """The two options cost nothing where they are not taken."""
    model = ExtendedModel(jnp.asarray(0.1), jnp.ones(3), jnp.ones(4), jnp.eye(4))
    inputs = ExtendedSample(jnp.ones((N, 3)), jnp.zeros(N))
    plain = jax.make_jaxpr(lambda m, i: run(ExtendedKalman(drifted, pushed, sighted), m, i))
    off = ExtendedKalman(drifted, pushed, sighted, (), 1, (False,) * 3)
    other = jax.make_jaxpr(lambda m, i: run(off, m, i))
    assert str(plain(model, inputs)) == str(other(model, inputs))
    assert "round" not in str(plain(model, inputs))


@pytest.mark.parametrize("times", [0, -1, 1.5, "2", None])
def test_the_number_of_turns_is_checked(times):
    with pytest.raises(ValueError, match="^ExtendedKalman: iterations is .*; give how often"):
        ExtendedKalman(drifted, pushed, sighted, iterations=times)


def test_there_is_a_word_for_every_measurement():
    model = ExtendedModel(jnp.asarray(0.1), jnp.ones(3), jnp.ones(4), jnp.eye(4))
    filter = ExtendedKalman(drifted, pushed, sighted, angles=(True, False))
    with pytest.raises(ValueError, match="^angles has 2 entries for 3 numbers; give one for each"):
        run(filter, model, ExtendedSample(jnp.ones((N, 3)), jnp.zeros(N)))


@given(rng=seeds())
def test_wrapped_differs_by_whole_turns(rng):
    angle = rng.normal(size=8) * 10.0 ** rng.integers(-3, 4)
    found = np.asarray(wrapped(angle))
    assert (np.abs(found) <= np.pi * (1 + 1e-12)).all()
    turns = (angle - found) / (2 * np.pi)
    assert (np.abs(turns - np.round(turns)) <= 1e-12 * (1 + np.abs(turns))).all()
