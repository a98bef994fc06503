"""Riccati equations against scipy, closed forms and 40 digits, with derivatives of both orders."""

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
import scipy.linalg
from jax.test_util import check_grads

from filters.small import product, solve
from objectives import care, dare, steady_gain, updated

EQUATIONS = {"dare": dare, "care": care}
batched = {name: jax.jit(jax.vmap(function)) for name, function in EQUATIONS.items()}


def models(n, m, count=20, radius=2.0):
    draw = np.random.default_rng(10 * n + m)
    A, B = draw.standard_normal((2, count, n, n))
    A = A * (draw.uniform(0.2, radius, count) / np.abs(np.linalg.eigvals(A)).max(1))[:, None, None]
    H, S = draw.standard_normal((count, m, n)), draw.standard_normal((count, m, m))
    return A, H, B @ B.transpose(0, 2, 1), S @ S.transpose(0, 2, 1) + 0.1 * np.eye(m)


def forty_digits(name, F, H, Q, R):
    """From the stable half of the eigenvectors: no iteration, no Riccati step."""
    n = len(F)
    with mpmath.workdps(40):
        F, H, Q, R = (mpmath.matrix(part.tolist()) for part in (F, H, Q, R))
        G, Z = H.T * R**-1 * H, mpmath.matrix(2 * n, 2 * n)
        if name == "dare":
            back = F**-1
            Z[:n, :n], Z[:n, n:] = F.T + G * back * Q, -G * back
            Z[n:, :n], Z[n:, n:] = -back * Q, back
        else:
            Z[:n, :n], Z[:n, n:], Z[n:, :n], Z[n:, n:] = F.T, -G, -Q, -F
        values, vectors = mpmath.eig(Z)
        size = abs if name == "dare" else mpmath.re
        half = [i for i, value in enumerate(values) if size(value) < (name == "dare")]
        U = mpmath.matrix([[vectors[r, c] for c in half] for r in range(2 * n)])
        P = U[n:, :] * U[:n, :] ** -1
        return np.array([[float(mpmath.re(P[i, j])) for j in range(n)] for i in range(n)])


def worst(found, expected):
    """The largest error as a share of the states' standard deviations."""
    deviation = np.sqrt(np.diag(expected))
    return (np.abs(found - expected) / np.outer(deviation, deviation)).max()


def check_derivatives(cost, point, step=1e-5):
    """Along one direction: forwards, backwards and the second, against central differences."""
    draw = np.random.default_rng(7)
    move = tuple(jnp.asarray(draw.standard_normal(part.shape)) for part in point)
    at = lambda t: [part + t * way for part, way in zip(point, move, strict=True)]  # noqa: E731
    value, slope = jax.jit(cost), jax.jit(jax.grad(lambda t: cost(*at(t))))
    both = jax.jit(jax.value_and_grad(jax.grad(lambda t: cost(*at(t)))))
    forward = jax.jit(lambda t: jax.jvp(lambda t: cost(*at(t)), (t,), (1.0,))[1])
    differences = [
        (float(function(step)) - float(function(-step))) / (2 * step)
        for function in (lambda t: value(*at(t)), slope)
    ]
    first, second = both(0.0)
    np.testing.assert_allclose([slope(0.0), forward(0.0), first], differences[0], rtol=1e-6)
    np.testing.assert_allclose(second, differences[1], rtol=1e-6)


@pytest.mark.parametrize(("n", "m"), [(1, 1), (3, 1), (5, 2)])
@pytest.mark.parametrize("name", EQUATIONS)
def test_agrees_with_scipy(name, n, m):
    """Detectable, stable or not: abs(eigenvalue) up to 2."""
    library = {"dare": scipy.linalg.solve_discrete_are, "care": scipy.linalg.solve_continuous_are}
    model = models(n, m)
    for P, F, H, Q, R in zip(batched[name](*model), *model, strict=True):
        expected = library[name](F.T, H.T, Q, R)  # scipy keeps eight digits of the worst
        np.testing.assert_allclose(P, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def small_noise(F, H, Q, R):
    return F, H, Q, 1e-12 * R


def far_units(F, H, Q, R):
    units = np.array([1e-6, 1e6, 1.0])
    return F * units[:, None] / units, H / units, Q * np.outer(units, units), R


def stiff(F, H, Q, R):
    A = np.diag([-1e3, -1.0, -1e-3]) + np.triu(F, 1)
    return scipy.linalg.expm(A * 1e-3), H, Q, R


@pytest.mark.parametrize("change", [small_noise, far_units, stiff])
def test_forty_digits_of_hard_discrete_models(change):
    model = change(*(part[0] for part in models(3, 1)))
    (found,) = batched["dare"](*(part[None] for part in model))
    # scipy refuses the first and keeps ten digits of the last
    assert worst(found, forty_digits("dare", *model)) < 1e-11


@pytest.mark.parametrize("change", [far_units, lambda *model: model], ids=["units", "plain"])
def test_forty_digits_of_continuous_models(change):
    model = change(*(part[1] for part in models(3, 1)))
    (found,) = batched["care"](*(part[None] for part in model))
    assert worst(found, forty_digits("care", *model)) < 1e-11


def test_an_unstable_mode_that_nothing_drives():
    """P = R (F^2 - 1) / H^2 in discrete, 2 a V in continuous time; zero is the wrong solution."""
    F, zero, R = np.full((1, 1, 1), 2.0), np.zeros((1, 1, 1)), np.full((1, 1, 1), 0.7)
    np.testing.assert_allclose(batched["dare"](F, F, zero, R), 0.7 * 3 / 4, rtol=1e-14)
    one = np.ones((1, 1, 1))
    np.testing.assert_allclose(batched["care"](F, one, zero, R), 4 * 0.7, rtol=1e-14)


@pytest.mark.parametrize("name", EQUATIONS)
def test_nan_without_a_steady_filter(name):
    on, unstable = (1.0, 2.0) if name == "dare" else (0.0, 1.0)
    stable = 0.5 if name == "dare" else -1.0
    F = np.array([np.diag([on, stable, stable]), np.diag([unstable, stable, stable])])
    H = np.array([[[1.0, 1.0, 0.0]], [[0.0, 1.0, 1.0]]])  # the first is seen, the second is not
    Q = np.array([np.diag([0.0, 1.0, 1.0]), np.eye(3)])
    assert np.isnan(batched[name](F, H, Q, np.ones((2, 1, 1)))).all()


@pytest.mark.parametrize("name", EQUATIONS)
def test_derivatives_of_two_orders(name):
    model = tuple(jnp.asarray(part[0]) for part in models(3, 2, radius=1.1))
    weight = jnp.asarray(np.random.default_rng(9).standard_normal((3, 3)))

    def cost(F, H, Q, R):
        return (weight * EQUATIONS[name](F, H, Q + Q.T, R + R.T)).sum()

    check_derivatives(cost, model)


def test_double_integrator_has_its_closed_form():
    draw = np.random.default_rng(5)
    Ts, qa, qb = np.exp(draw.uniform(np.log(1e-2), np.log(10), (3, 200)))
    zero, one = np.zeros_like(Ts), np.ones_like(Ts)
    F = np.array([[one, zero], [Ts, one]]).transpose(2, 0, 1)
    Q = qa * np.array([[Ts, Ts**2 / 2], [Ts**2 / 2, Ts**3 / 3]])
    H, R = np.broadcast_to([[0.0, 1.0]], (200, 1, 2)), qb[:, None, None]
    P = batched["dare"](F, H, Q.transpose(2, 0, 1), R)
    K = jax.vmap(lambda P, H, R: updated(P, H, R) @ H.T / R)(P, H, R)[..., 0]
    A = qa * (Ts**2 + np.sqrt(Ts**4 / 3 + 16 * qb * Ts / qa)) / 2
    B = np.sqrt(A**2 - 4 * qa * qb * Ts)
    q = 2 * qa * qb * Ts
    expected = np.array([(A - B) / (2 * qb), 1 - q / (A * B + B**2 + q)])
    np.testing.assert_allclose(K.T, expected, rtol=1e-8)
    np.testing.assert_allclose(jax.vmap(steady_gain)(P, H, R)[..., 0], K, rtol=1e-9)


@pytest.mark.parametrize("n", [1, 4, 9])
def test_small_solve_and_product(n):
    draw = np.random.default_rng(n)
    A, B = draw.standard_normal((2, n, n))
    A[0, 0] = 0.0 if n > 1 else 1.0  # a row has to be exchanged
    units = 10.0 ** draw.integers(-12, 12, n)
    np.testing.assert_allclose(product(A, B, A), A @ B @ A, rtol=1e-10, atol=1e-12)
    expected = np.linalg.solve(A, B)
    found = solve(jnp.asarray(A * units[:, None]), jnp.asarray(B * units[:, None]))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    weight = lambda A, B: (solve(A, B) * B).sum()  # noqa: E731
    check_grads(weight, (A, B), order=1, modes=("rev",), rtol=1e-4, atol=1e-4)
