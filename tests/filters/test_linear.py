"""The linear Kalman filter against a textbook loop and against one big least-squares problem."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from jax.flatten_util import ravel_pytree

from filters import LinearKalman, LinearModel, Sample, Transition, run
from tests.oracles import Model, central_difference, conditional_mean, exact_inertial, linear_kalman
from tests.strategies import covariance, stable_models

compiled = jax.jit(run, static_argnums=0)

# A dozen samples, each some ten operations deep and with gains of order one, against a solve.
SAME = 1e-10


def close(actual, expected, tolerance=SAME):
    scale = max(np.abs(expected).max(), 1e-300)
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance * scale)


def built(model: Model, **changes):
    n = len(model.P0)
    move = Transition(F=jnp.asarray(model.F), G=jnp.eye(n), Q=jnp.asarray(model.W))
    parts = {name: jnp.asarray(getattr(model, name)) for name in ("H", "R", "P0", "x0")}
    return LinearModel(transition=move, **parts)._replace(**changes)


def filtered(params, z, **inputs):
    return compiled(LinearKalman(), params, Sample(jnp.asarray(z), **inputs))[1]


@cache
def example(n=3, m=2, N=12):
    rng = np.random.default_rng(1960)
    F = np.array([[0.9, 0.2, 0.0], [-0.2, 0.9, 0.1], [0.0, 0.0, 0.95]])
    W, P0 = covariance(rng, n, 2), np.ones((n, n))
    R = covariance(rng, m, m) + 0.5 * np.eye(m)
    model = Model(F, W, rng.normal(size=(m, n)), R, P0, rng.normal(size=n))
    return model, rng.normal(size=(N, m))


@given(drawn=stable_models())
def test_equals_the_textbook_for_any_model_and_any_holes(drawn):
    model, z = drawn
    actual, expected = filtered(built(model), z), linear_kalman(model, z)
    close(actual.x, expected.x)
    np.testing.assert_allclose(actual.P, expected.P, rtol=0, atol=SAME * covariances(model))


@given(drawn=stable_models())
def test_diagonal_R_equals_the_same_R_written_in_full(drawn):
    model, z = drawn
    diagonal = np.diag(model.R)
    actual = filtered(built(model, R=jnp.asarray(diagonal)), z)
    expected = linear_kalman(model._replace(R=np.diag(diagonal)), z)
    close(actual.x, expected.x)
    np.testing.assert_allclose(actual.P, expected.P, rtol=0, atol=SAME * covariances(model))


@given(drawn=stable_models())
def test_only_the_ratio_of_the_covariances_counts_for_the_estimate(drawn):
    model, z = drawn
    scaled = model._replace(W=7.3 * model.W, R=7.3 * model.R, P0=7.3 * model.P0)
    one, other = filtered(built(model), z), filtered(built(scaled), z)
    close(other.x, one.x)
    np.testing.assert_allclose(other.P, 7.3 * one.P, rtol=0, atol=SAME * covariances(scaled))


@given(drawn=stable_models())
def test_covariance_stays_symmetric_and_positive(drawn):
    model, z = drawn
    P = np.asarray(filtered(built(model), z).P)
    np.testing.assert_array_equal(P, P.swapaxes(1, 2))
    # a zero eigenvalue may come out negative by its rounding, relative to the largest entry
    assert np.linalg.eigvalsh(P).min() >= -1e-14 * covariances(model)


def covariances(model):
    """The size of what the covariance of the estimate is computed from."""
    return max(np.abs(part).max() for part in (model.W, model.R, model.P0))


@pytest.mark.parametrize("P0", ["ones", "zero", "full"])
def test_equals_one_big_least_squares_problem(P0):
    model, z = example()
    starts = {"ones": np.ones((3, 3)), "zero": np.zeros((3, 3)), "full": np.diag([1.0, 2.0, 3.0])}
    model = model._replace(P0=starts[P0])
    actual = filtered(built(model), z)
    x, P = conditional_mean(model, z)
    close(actual.x[-1], x)  # the joint covariance has a condition of some 1e3
    close(actual.P[-1], P)


def test_without_noise_and_start_it_is_a_line_fit():
    """A constant-rate model without process noise and with a wide start is numpy's polyfit."""
    T, N = 0.1, 12
    z = np.random.default_rng(8).normal(size=(N, 1))
    model = Model(
        F=np.array([[1.0, T], [0.0, 1.0]]),
        W=np.zeros((2, 2)),
        H=np.array([[1.0, 0.0]]),
        R=np.array([[0.3]]),
        P0=1e8 * np.eye(2),
        x0=np.zeros(2),
    )
    slope, level = np.polyfit(T * (np.arange(N) - N + 1), z[:, 0], 1)
    # The start weighs R / P0 = 3e-9 against the data.
    np.testing.assert_allclose(filtered(built(model), z).x[-1], [level, slope], atol=1e-7)


def test_control_input_moves_the_state():
    model, z = example()
    rng = np.random.default_rng(9)
    B, u = rng.normal(size=(3, 2)), rng.normal(size=(len(z), 2))
    params = built(model)
    params = params._replace(transition=params.transition._replace(B=jnp.asarray(B)))
    actual = filtered(params, z, u=jnp.asarray(u))
    close(actual.x, linear_kalman(model, z, pushes=u @ B.T).x)


def test_control_input_without_its_matrix_is_an_error():
    model, z = example()
    with pytest.raises(ValueError, match="B"):
        filtered(built(model), z, u=jnp.zeros((len(z), 1)))


def test_noise_enters_through_G():
    model, z = example()
    rng = np.random.default_rng(10)
    G, Q = rng.normal(size=(3, 2)), covariance(rng, 2, 2)
    move = Transition(F=jnp.asarray(model.F), G=jnp.asarray(G), Q=jnp.asarray(Q))
    actual = filtered(built(model, transition=move), z)
    expected = linear_kalman(model._replace(W=G @ Q @ G.T), z)
    close(actual.x, expected.x)
    close(actual.P, expected.P)


def test_a_sample_may_bring_its_own_transition():
    model, z = example()
    dt = np.random.default_rng(11).choice([0.1, 0.25, 1.0], len(z))
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -0.5]])
    F = np.array([scipy.linalg.expm(A * t) for t in dt])
    G, Q = np.tile(np.eye(3)[:, :2], (len(dt), 1, 1)), dt[:, None, None] * np.diag([0.2, 0.7])
    steps = Transition(*(jnp.asarray(part) for part in (F, G, Q)))
    actual = filtered(built(model), z, transition=steps)
    varying = model._replace(F=F, W=G @ Q @ G.swapaxes(1, 2))
    close(actual.x, linear_kalman(varying, z).x)
    close(actual.P, linear_kalman(varying, z).P)


def test_several_signals_are_several_filters():
    model, z = example()
    rng = np.random.default_rng(12)
    many = rng.normal(size=(*z.shape, 3))
    many[4, 0] = np.nan
    starts = rng.normal(size=(3, 3))
    together = filtered(built(model, x0=jnp.asarray(starts)), many)
    for i in range(3):
        alone = linear_kalman(model._replace(x0=starts[:, i]), many[..., i])
        close(together.x[..., i], alone.x)
        close(together.P, alone.P)


def test_missing_samples_are_predictions():
    model, z = example()
    z = z.copy()
    z[5:] = np.nan
    outputs = filtered(built(model), z)
    ahead = [np.linalg.matrix_power(model.F, k) @ outputs.x[4] for k in range(1, len(z) - 4)]
    close(outputs.x[5:], np.array(ahead))
    np.testing.assert_array_equal(outputs.innovation[5:], 0.0)
    np.testing.assert_array_equal(outputs.variance[5:], 0.0)
    np.testing.assert_array_equal(outputs.gain[5:], 0.0)


def test_innovations_have_the_likelihood_of_the_joint_distribution():
    """Sum of log normal densities of the decorrelated innovations = the joint one, R full."""
    model, z = example()
    outputs = filtered(built(model), z)
    s, y = np.asarray(outputs.variance), np.asarray(outputs.innovation)
    actual = -0.5 * (np.log(2 * np.pi * s) + y**2 / s).sum()
    x, P, expected = model.x0, model.P0, 0.0
    for row in z:
        x, P = model.F @ x, model.F @ P @ model.F.T + model.W
        S, e = model.H @ P @ model.H.T + model.R, row - model.H @ x
        _, log = np.linalg.slogdet(2 * np.pi * S)
        expected -= 0.5 * (log + e @ np.linalg.solve(S, e))
        K = P @ model.H.T @ np.linalg.inv(S)
        x, P = x + K @ e, P - K @ S @ K.T
    assert actual == pytest.approx(expected, rel=SAME)


def test_precise_measurements_of_a_rank_one_start_keep_nine_digits():
    """R = 1e-12 and P0 = ones, the worst case of the papers, against 40 digits."""
    T, N = 1e-2, 300
    model = Model(
        F=np.array([[1.0, T], [0.0, 1.0]]),
        W=1e-9 * np.eye(2),
        H=np.array([[1.0, 0.0]]),
        R=np.array([[1e-12]]),
        P0=np.ones((2, 2)),
        x0=np.zeros(2),
    )
    z = 0.2 * np.sin(0.1 * np.arange(N))
    exact = exact_inertial(T, (1e-12, 1e-9 / T**2, np.ones((2, 2))), z, measured=0)
    actual = filtered(built(model), z[:, None]).x[:, 0]
    np.testing.assert_allclose(actual, exact, rtol=0, atol=1e-9 * 0.2)  # what the project promises


def test_gradient_in_every_parameter_equals_central_differences():
    """F, G, Q, H, R, P0 and x0 at once, with holes."""
    model, z = example()
    z = z.copy()
    z[3, 0], z[7] = np.nan, np.nan
    flat, unflatten = ravel_pytree(built(model))

    @jax.jit
    def total(point):
        outputs = run(LinearKalman(), unflatten(point), Sample(jnp.asarray(z)))[1]
        return (outputs.x**2).sum() + outputs.P.sum() + (outputs.innovation**2).sum()

    gradient = jax.jit(jax.grad(total))(flat)
    difference = central_difference(total, np.asarray(flat), 1e-5)
    # h = 1e-5: h^2 = 1e-10 of truncation, eps/h = 2e-11 of rounding, each times about ten
    scale = np.abs(difference).max()
    np.testing.assert_allclose(gradient, difference, rtol=0, atol=1e-8 * scale)
