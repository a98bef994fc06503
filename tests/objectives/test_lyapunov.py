"""Lyapunov and Stein equations against scipy and 40 digits, with derivatives of both orders."""

from functools import partial

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
import scipy.linalg

from objectives.linear_systems.lyapunov import lyapunov, stein

SIZES = (1, 3, 9)  # written out, and the last by the libraries
LOT = 20  # models in a call: every other number of them, and every other shape, is a compilation
EQUATIONS = {"stein": stein, "lyapunov": lyapunov}
# Without the compiler's optimisation, which changes no formula and takes half of the time.
quickly = partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})
batched = {name: quickly(jax.vmap(function)) for name, function in EQUATIONS.items()}


def solved(name, A, Q):
    """The solution of one model, in a lot of the same."""
    X = batched[name](*(np.repeat(part[None], LOT, axis=0) for part in (A, Q)))
    np.testing.assert_array_equal(X, np.broadcast_to(X[0], X.shape))
    return X[0]


def models(name, n, count=LOT):
    draw = np.random.default_rng(n)
    A, B = draw.standard_normal((2, count, n, n))
    poles = np.linalg.eigvals(A)
    if name == "stein":
        A = A * (draw.uniform(0.1, 0.99, count) / np.abs(poles).max(axis=1))[:, None, None]
    else:
        A = A - (poles.real.max(axis=1) + 0.1)[:, None, None] * np.eye(n)
    return A, B @ B.transpose(0, 2, 1)


def forty_digits(name, A, Q):
    """One linear system in the entries of X."""
    n = len(A)
    with mpmath.workdps(40):
        system = mpmath.matrix(n * n, n * n)
        for i, j, k in np.ndindex(n, n, n):
            if name == "stein":
                for p in range(n):
                    system[i * n + j, k * n + p] -= mpmath.mpf(float(A[i, k])) * float(A[j, p])
            else:
                system[i * n + j, k * n + j] -= float(A[i, k])
                system[i * n + j, i * n + k] -= float(A[j, k])
        if name == "stein":
            system += mpmath.eye(n * n)
        X = mpmath.lu_solve(system, mpmath.matrix(Q.reshape(-1).tolist()))
        return np.array([float(x) for x in X]).reshape(n, n)


def check_derivatives(cost, point, step=1e-5, *, twice_backwards):
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
    if twice_backwards:
        found = quickly(jax.value_and_grad(jax.grad(along)))(0.0)
        np.testing.assert_allclose(found, [first_difference, second_difference], rtol=1e-6)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("name", EQUATIONS)
def test_agrees_with_scipy(name, n):
    A, Q = models(name, n)
    found = batched[name](A, Q)
    solve = {
        "stein": scipy.linalg.solve_discrete_lyapunov,
        "lyapunov": lambda a, q: scipy.linalg.solve_continuous_lyapunov(a, -q),
    }[name]
    for X, a, q in zip(found, A, Q, strict=True):
        expected = solve(a, q)  # poles at a hundredth of the stability bound
        np.testing.assert_allclose(X, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("name", EQUATIONS)
def test_stiff_and_in_units_far_apart(name):
    """Time constants over six decades, states in units from 1e-6 to 1e6."""
    draw = np.random.default_rng(0)
    A = np.diag([-1e3, -1.0, -1e-3]) + np.triu(draw.standard_normal((3, 3)), 1)
    A = scipy.linalg.expm(A * 1e-3) if name == "stein" else A
    B = draw.standard_normal((3, 3))
    units = np.array([1e-6, 1e6, 1.0])
    A, Q = A * units[:, None] / units, B @ B.T * np.outer(units, units)
    expected = forty_digits(name, A, Q)
    found = solved(name, A, Q)
    deviation = np.sqrt(np.diag(expected))
    # a rate of 1e-6 a sample is known to 1e-10 from F
    share = {"stein": 1e-9, "lyapunov": 1e-12}[name]
    assert (np.abs(found - expected) / np.outer(deviation, deviation)).max() < share


@pytest.mark.parametrize("name", EQUATIONS)
def test_derivatives_of_two_orders(name):
    A, Q = (jnp.asarray(part[0]) for part in models(name, 2))
    weight = jnp.asarray(np.random.default_rng(9).standard_normal((2, 2)))
    cost = lambda A, Q: (weight * EQUATIONS[name](A, Q)).sum()  # noqa: E731
    check_derivatives(cost, (A, Q), twice_backwards=name == "stein")


@pytest.mark.parametrize(
    ("name", "diagonal"),
    [
        ("stein", (0.5, 1.0, 0.1)),
        ("stein", (0.5, -1.5, 0.1)),
        ("stein", (1e200, 0.0, 0.0)),
        ("lyapunov", (-1.0, 0.0, -2.0)),
        ("lyapunov", (-1.0, 1e-3, -2.0)),
    ],
)
def test_nan_without_stability(name, diagonal):
    A = np.diag(diagonal)
    A[0, 1] = 1.0
    assert np.isnan(solved(name, A, np.eye(3))).all()
