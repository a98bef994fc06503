"""Riccati equations against scipy, closed forms and 40 digits, with derivatives of both orders."""

from functools import partial

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
import scipy.linalg

from filters.small_linalg import product, solve
from objectives import care, dare, steady_gain, updated

EQUATIONS = {"dare": dare, "care": care}
LOT = 20  # models in a call: every other number of them, and every other shape, is a compilation
# Without the compiler's optimisation, which changes no formula and takes half of the time.
quickly = partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})
batched = {name: quickly(jax.vmap(function)) for name, function in EQUATIONS.items()}
gains = quickly(jax.vmap(lambda P, H, R: (updated(P, H, R) @ H.T / R, steady_gain(P, H, R))))


def solved(name, *models):
    """Solutions of any number of models, a full lot at a time."""
    count = len(models[0])
    full = -(-count // LOT) * LOT
    lots = zip(
        *(
            np.resize(part, (full, *part.shape[1:])).reshape(-1, LOT, *part.shape[1:])
            for part in models
        ),
        strict=True,
    )
    return np.concatenate([batched[name](*lot) for lot in lots])[:count]


def models(n, m, count=LOT, radius=2.0):
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
    """Along one direction: forwards, backwards and the second, against central differences.

    The second is forwards over backwards, in one compiled function with the first ones.
    """
    draw = np.random.default_rng(7)
    move = tuple(jnp.asarray(draw.standard_normal(part.shape)) for part in point)
    along = lambda t: cost(*(part + t * way for part, way in zip(point, move, strict=True)))  # noqa: E731
    both = quickly(lambda t: jax.jvp(jax.value_and_grad(along), (t,), (1.0,)))
    (_, slope), (forward, second) = both(0.0)
    ahead, behind = (np.array(both(t)[0]) for t in (step, -step))
    first_difference, second_difference = (ahead - behind) / (2 * step)
    np.testing.assert_allclose([slope, forward], first_difference, rtol=1e-6)
    np.testing.assert_allclose(second, second_difference, rtol=1e-6)


@pytest.mark.parametrize(("n", "m"), [(1, 1), (3, 1), (9, 2)])
@pytest.mark.parametrize("name", EQUATIONS)
def test_agrees_with_scipy(name, n, m):
    """Detectable, stable or not: abs(eigenvalue) up to 2."""
    library = {"dare": scipy.linalg.solve_discrete_are, "care": scipy.linalg.solve_continuous_are}
    model = models(n, m)
    for P, F, H, Q, R in zip(solved(name, *model), *model, strict=True):
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
    (found,) = solved("dare", *(part[None] for part in model))
    # scipy refuses the first and keeps ten digits of the last
    assert worst(found, forty_digits("dare", *model)) < 1e-11


@pytest.mark.parametrize("change", [far_units, lambda *model: model], ids=["units", "plain"])
def test_forty_digits_of_continuous_models(change):
    model = change(*(part[1] for part in models(3, 1)))
    (found,) = solved("care", *(part[None] for part in model))
    assert worst(found, forty_digits("care", *model)) < 1e-11


def test_an_unstable_mode_that_nothing_drives():
    """P = R (F^2 - 1) / H^2 in discrete, 2 a V / C^2 in continuous time; zero is wrong."""
    zero, R = np.zeros((1, 3, 3)), np.full((1, 1, 1), 0.7)
    H, expected = np.array([[[2.0, 0.0, 0.0]]]), np.zeros((1, 3, 3))
    for name, rest, level in (("dare", 0.5, 0.7 * 3 / 4), ("care", -1.0, 0.7)):
        F = np.diag([2.0, rest, rest])[None]
        expected[0, 0, 0] = level
        np.testing.assert_allclose(solved(name, F, H, zero, R), expected, rtol=1e-14)


@pytest.mark.parametrize("name", EQUATIONS)
def test_nan_without_a_steady_filter(name):
    on, unstable = (1.0, 2.0) if name == "dare" else (0.0, 1.0)
    stable = 0.5 if name == "dare" else -1.0
    F = np.array([np.diag([on, stable, stable]), np.diag([unstable, stable, stable])])
    H = np.array([[[1.0, 1.0, 0.0]], [[0.0, 1.0, 1.0]]])  # the first is seen, the second is not
    Q = np.array([np.diag([0.0, 1.0, 1.0]), np.eye(3)])
    assert np.isnan(solved(name, F, H, Q, np.ones((2, 1, 1)))).all()


@pytest.mark.parametrize("name", EQUATIONS)
def test_derivatives_of_two_orders(name):
    model = tuple(jnp.asarray(part[0]) for part in models(2, 1, radius=1.1))
    weight = jnp.asarray(np.random.default_rng(9).standard_normal((2, 2)))

    def cost(F, H, Q, R):
        return (weight * EQUATIONS[name](F, H, Q + Q.T, R + R.T)).sum()

    check_derivatives(cost, model)


def test_double_integrator_has_its_closed_form():
    draw = np.random.default_rng(5)
    Ts, qa, qb = np.exp(draw.uniform(np.log(1e-2), np.log(10), (3, 200)))
    zero, one = np.zeros_like(Ts), np.ones_like(Ts)
    # a third state that nothing shows, for the shape of the other tests
    F = np.array([[one, zero, zero], [Ts, one, zero], [zero, zero, zero]]).transpose(2, 0, 1)
    rows = [Ts, Ts**2 / 2, zero], [Ts**2 / 2, Ts**3 / 3, zero], [zero, zero, one]
    Q = (qa * np.array(rows)).transpose(2, 0, 1)
    H, R = np.broadcast_to([[0.0, 1.0, 0.0]], (200, 1, 3)), qb[:, None, None]
    P = solved("dare", F, H, Q, R)
    K, direct = (np.asarray(part)[..., 0] for part in gains(P, H, R))
    A = qa * (Ts**2 + np.sqrt(Ts**4 / 3 + 16 * qb * Ts / qa)) / 2
    B = np.sqrt(A**2 - 4 * qa * qb * Ts)
    q = 2 * qa * qb * Ts
    expected = np.array([(A - B) / (2 * qb), 1 - q / (A * B + B**2 + q)])
    np.testing.assert_allclose(K[:, :2].T, expected, rtol=1e-8)
    np.testing.assert_allclose(direct, K, rtol=1e-9)


@quickly
def multiplied_and_solved(A, B, ways):
    """The product, the solution, a number made of it and its slope along the ways."""

    def weight(A, B):
        X = solve(A, B)
        return (X * B).sum(), X

    (value, X), slopes = jax.value_and_grad(weight, argnums=(0, 1), has_aux=True)(A, B)
    backward = sum((slope * way).sum() for slope, way in zip(slopes, ways, strict=True))
    return product(A, B, A), X, value, backward


@pytest.mark.parametrize("n", [1, 4, 9])
def test_small_solve_and_product(n):
    draw = np.random.default_rng(n)
    A, B = draw.standard_normal((2, n, n))
    A[0, 0] = 0.0 if n > 1 else 1.0  # a row has to be exchanged
    units = 10.0 ** draw.integers(-12, 12, n)
    ways = draw.standard_normal((2, n, n))
    threefold, _, _, slope = multiplied_and_solved(A, B, ways)
    np.testing.assert_allclose(threefold, A @ B @ A, rtol=1e-10, atol=1e-12)
    expected = np.linalg.solve(A, B)
    found = multiplied_and_solved(A * units[:, None], B * units[:, None], ways)[1]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    h = 1e-5
    ahead, behind = (
        multiplied_and_solved(*(np.array([A, B]) + t * ways), ways)[2] for t in (h, -h)
    )
    np.testing.assert_allclose(slope, (ahead - behind) / (2 * h), rtol=1e-4, atol=1e-4)
