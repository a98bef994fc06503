"""The exact start against Durbin and Koopman's recursion, least squares and the chain filters."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import (
    ConstantAcceleration,
    ConstantAccelerationNoise,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    LinearKalman,
    LinearModel,
    PositionSample,
    Sample,
    Transition,
    run,
)
from filters.integrators import full, white_noise

N, DIFFUSE = 14, (0, 2, 3)


def random_model(seed=0, n=4, m=2):
    draw = np.random.default_rng(seed)
    F = np.eye(n) + 0.4 * draw.standard_normal((n, n))
    F /= np.abs(np.linalg.eigvals(F)).max()  # what grows costs the oracles their digits
    H = draw.standard_normal((m, n))
    root = draw.standard_normal((n, n))
    P0 = np.zeros((n, n))
    P0[1, 1] = 0.7
    z = draw.standard_normal((N, m))
    z[0, 1] = z[2, 0] = np.nan
    return F, H, 0.1 * root @ root.T, np.array([0.3, 0.8]), P0, np.array([9.0, 0.5, -7.0, 3.0]), z


def as_model(F, H, Q, R, P0, x0):
    one = jnp.eye(len(F))
    move = Transition(jnp.asarray(F), one, jnp.asarray(Q))
    return LinearModel(move, *map(jnp.asarray, (H, R, P0, x0)))


def durbin_koopman(F, H, Q, R, P0, x0, z, diffuse):
    """Chapter 5, one measurement after another, with P = kappa P_inf + P_star."""
    infinite = np.diag([1.0 if i in diffuse else 0.0 for i in range(len(F))])
    x, P, found = np.array(x0), np.array(P0), []
    for sample in z:
        x, P, infinite = F @ x, F @ P @ F.T + Q, F @ infinite @ F.T
        for h, r, zk in zip(H, R, sample, strict=True):
            if np.isnan(zk):
                found.append((0.0, 0.0))
                continue
            y, s, M = zk - h @ x, h @ P @ h + r, P @ h
            s_inf, M_inf = h @ infinite @ h, infinite @ h
            if s_inf > 1e-8:
                K = M_inf / s_inf
                P = P + np.outer(M_inf, M_inf) * s / s_inf**2
                P = P - (np.outer(M, M_inf) + np.outer(M_inf, M)) / s_inf
                infinite = infinite - np.outer(M_inf, M_inf) / s_inf
                x = x + K * y
                found.append((0.0, 0.0))
                continue
            x, P = x + M / s * y, P - np.outer(M, M) / s
            found.append((y, s))
    return x, P, np.array(found).reshape(len(z), -1, 2)


def least_squares(F, H, Q, R, P0, x0, z, diffuse):
    """The last state from all measurements at once: diffuse states are unknown constants."""
    n, d = len(F), len(diffuse)
    E = np.eye(n)[:, list(diffuse)]
    known = np.array([0.0 if i in diffuse else x0[i] for i in range(n)])
    # The state at k is A_k delta + c_k + noise, of the covariance cov[k][j] with that at j.
    A, c, powers = [], [], [np.eye(n)]
    for _ in range(len(z)):
        powers.append(F @ powers[-1])
    V = [P0]
    for k in range(1, len(z) + 1):
        A.append(powers[k] @ E)
        c.append(powers[k] @ known)
        V.append(F @ V[-1] @ F.T + Q)
    cov = np.block(
        [
            [
                powers[k - j] @ V[j] if k >= j else V[k] @ powers[j - k].T
                for j in range(1, len(z) + 1)
            ]
            for k in range(1, len(z) + 1)
        ]
    )
    big = np.kron(np.eye(len(z)), H)
    rows = ~np.isnan(z).ravel()
    G, y = big[rows], (z.ravel() - big @ np.concatenate(c))[rows]
    S = G @ cov @ G.T + np.diag(np.tile(R, len(z)))[np.ix_(rows, rows)]
    X = G @ np.vstack(A)
    inverse = np.linalg.inv(S)
    precise = X.T @ inverse @ X
    delta = np.linalg.solve(precise, X.T @ inverse @ y)
    last = slice(n * (len(z) - 1), None)
    B = cov[last] @ G.T @ inverse
    x = A[-1] @ delta + c[-1] + B @ (y - X @ delta)
    D = A[-1] - B @ X
    P = cov[last, last] - B @ G @ cov[:, last] + D @ np.linalg.solve(precise, D.T)
    assert d == np.linalg.matrix_rank(X)
    return x, P


@pytest.mark.parametrize("seed", range(4))
def test_it_is_the_recursion_of_durbin_and_koopman_and_least_squares(seed):
    *model, z = random_model(seed)
    outputs = run(LinearKalman(DIFFUSE), as_model(*model), Sample(jnp.asarray(z)))[1]
    x, P, innovations = durbin_koopman(*model, z, DIFFUSE)
    np.testing.assert_allclose(outputs.x[-1], x, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(outputs.P[-1], P, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(outputs.innovation, innovations[..., 0], rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(outputs.variance, innovations[..., 1], rtol=1e-8, atol=1e-8)
    x, P = least_squares(*model, z, DIFFUSE)
    np.testing.assert_allclose(outputs.x[-1], x, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(outputs.P[-1], P, rtol=1e-8, atol=1e-8)


def test_one_measurement_a_direction_is_used_up():
    *model, z = random_model()
    outputs = run(LinearKalman(DIFFUSE), as_model(*model), Sample(jnp.asarray(z)))[1]
    unused = np.isnan(z).sum() + len(DIFFUSE)
    assert int((outputs.variance == 0).sum()) == unused


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_units_of_states_do_not_matter(unit):
    F, H, Q, R, P0, x0, z = random_model(2)
    T = np.diag([unit, 1.0, 1 / unit, unit**0.5])
    back = np.linalg.inv(T)
    other = as_model(T @ F @ back, H @ back, T @ Q @ T, R, T @ P0 @ T, T @ x0)
    outputs = run(LinearKalman(DIFFUSE), other, Sample(jnp.asarray(z)))[1]
    plain = run(LinearKalman(DIFFUSE), as_model(F, H, Q, R, P0, x0), Sample(jnp.asarray(z)))[1]
    np.testing.assert_allclose(outputs.variance, plain.variance, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(outputs.innovation, plain.innovation, rtol=1e-7, atol=1e-7)


def test_the_start_of_diffuse_states_does_not_matter():
    F, H, Q, R, P0, x0, z = random_model(1)
    one = run(LinearKalman(DIFFUSE), as_model(F, H, Q, R, P0, x0), Sample(jnp.asarray(z)))[1]
    P0, x0 = P0 + 0.1, x0 + np.array([1e3, 0.0, -2e3, 5.0])
    P0[1, 1] = 0.7
    other = run(LinearKalman(DIFFUSE), as_model(F, H, Q, R, P0, x0), Sample(jnp.asarray(z)))[1]
    np.testing.assert_allclose(one.x[-1], other.x[-1], rtol=1e-8)


def test_it_is_constant_acceleration():
    dt, q, R = 0.4, 0.3, 0.5
    z = np.random.default_rng(3).standard_normal(30)
    z[[0, 2, 7]] = np.nan
    F = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
    Q = np.asarray(full(white_noise(3, 3, q, dt)))
    model = as_model(F, np.eye(1, 3), Q, np.array([R]), np.zeros((3, 3)), np.zeros(3))
    outputs = run(LinearKalman((0, 1, 2)), model, Sample(jnp.asarray(z)[:, None]))[1]
    noise = ConstantAccelerationNoise(jnp.array(q), jnp.array(R))
    known = run(ConstantAcceleration(dt), noise, PositionSample(jnp.asarray(z)))[1]
    np.testing.assert_allclose(outputs.variance, known.variance, rtol=1e-10)
    np.testing.assert_allclose(outputs.innovation, known.innovation, rtol=1e-8, atol=1e-11)
    np.testing.assert_allclose(outputs.x[-1, 2], known.acceleration[-1, 0], rtol=1e-9)


def test_two_sensors_of_one_state_begin_it_once():
    one = jnp.eye(1)
    model = LinearModel(Transition(one, one, 0 * one), jnp.ones((2, 1)), jnp.ones(2), one, one[0])
    outputs = run(LinearKalman((0,)), model, Sample(jnp.array([[3.0, 5.0], [4.0, 4.0]])))[1]
    assert outputs.variance[0].tolist() == [0.0, 2.0]
    assert outputs.innovation[0].tolist() == [0.0, 2.0]
    assert outputs.x[0].tolist() == [4.0]


def moved(p, x, u):
    return p[0] @ x


def shaken(p, x, u):
    return p[1]


def seen(p, x, u):
    return p[2] @ x


def test_the_extended_filter_of_a_linear_model_is_the_linear_one():
    F, H, Q, R, P0, x0, z = random_model(3)
    model = ExtendedModel(tuple(map(jnp.asarray, (F, Q, H))), *map(jnp.asarray, (R, x0, P0)))
    extended = ExtendedKalman(moved, shaken, seen, DIFFUSE)
    outputs = run(extended, model, ExtendedSample(jnp.asarray(z)))[1]
    linear = run(LinearKalman(DIFFUSE), as_model(F, H, Q, R, P0, x0), Sample(jnp.asarray(z)))[1]
    for name in ("x", "P", "innovation", "variance"):
        np.testing.assert_allclose(
            getattr(outputs, name), getattr(linear, name), rtol=1e-8, atol=1e-8, err_msg=name
        )


def test_the_gradient_passes_the_start():
    F, H, Q, R, P0, x0, z = random_model(0)

    def loss(logs):
        q, r = jnp.exp(logs)
        model = as_model(F, H, Q, R, P0, x0)
        move = model.transition._replace(Q=q * model.transition.Q)
        out = run(LinearKalman(DIFFUSE), model._replace(transition=move, R=r * model.R), Sample(z))[
            1
        ]
        return (out.innovation**2).sum() + out.variance.sum()

    z = jnp.asarray(z)
    at, h = jnp.zeros(2), 1e-5
    quick = jax.jit(loss)
    slope = [(quick(at + h * e) - quick(at - h * e)) / (2 * h) for e in np.eye(2)]
    np.testing.assert_allclose(jax.jit(jax.grad(loss))(at), slope, rtol=1e-6)
    np.testing.assert_allclose(jax.jit(jax.jacfwd(loss))(at), slope, rtol=1e-6)


@pytest.mark.parametrize("diffuse", [(0, 0), (4,), (-1,)])
def test_states_that_there_are_not_are_refused(diffuse):
    *model, _ = random_model()
    with pytest.raises(ValueError, match="of a model with 4: name each once, from 0 to 3"):
        LinearKalman(diffuse).init(as_model(*model))
