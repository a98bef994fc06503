"""The steps' derivatives against central differences, forwards, backwards and twice."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import (
    Estimate,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
    predict,
    run,
    run_kept,
    update,
)
from filters.kalman import update_rows
from tests.oracles import central_difference
from tests.strategies import covariance

# Central differences of numbers around 1 with a step of 1e-5: rounding 1e-11, curvature 1e-10.
DIFFERENCES = 1e-8
ORDER = 1e-13  # the same formula summed in another order


def advanced(point, n):
    """A weighted sum of all that a prediction gives, by F, x, a root of P and a root of W."""
    F, x, root, noise = point[: n * n], point[n * n : n * n + n], *jnp.split(point[n * n + n :], 2)
    F, root, noise = (part.reshape(n, n) for part in (F, root, noise))
    after = predict(Estimate(x, root @ root.T), F, noise @ noise.T)
    return weighed((after.x, after.P))


def measured(point, n, z, signals):
    """The same of an update, by x, a root of P, h, r and a shift of z."""
    sizes = np.cumsum([n * max(signals, 1), n * n, n, 1])
    x, root, h, r, shift = jnp.split(point, sizes)
    root = root.reshape(n, n)
    if signals:
        x, z = x.reshape(n, signals), jnp.full(signals, z) + shift * jnp.arange(signals)
    else:
        z = z + shift[0]
    after, innovation = update(Estimate(x, root @ root.T), h, jnp.exp(r[0]), z)
    return weighed((after.x, after.P, innovation))


def weighed(tree):
    leaves = jax.tree.leaves(tree)
    weights = [np.cos(1.0 + np.arange(leaf.size)).reshape(leaf.shape) for leaf in leaves]
    # A covariance is symmetric, and only what is symmetric in its weights counts.
    return sum((weight * leaf**2).sum() for weight, leaf in zip(weights, leaves, strict=True))


def both_ways(function, point):
    value = jax.jit(function)
    numeric = central_difference(lambda at: float(value(jnp.asarray(at))), point, 1e-5)
    scale = np.abs(numeric).max()
    back, forth = jax.jit(jax.grad(function))(point), jax.jit(jax.jacfwd(function))(point)
    np.testing.assert_allclose(back, numeric, rtol=0, atol=DIFFERENCES * scale)
    np.testing.assert_allclose(back, forth, rtol=0, atol=ORDER * scale)


@pytest.mark.parametrize("n", [2, 9])  # products change their form above 8
def test_a_prediction_is_differentiated_both_ways(n):
    rng = np.random.default_rng(n)
    both_ways(partial(advanced, n=n), rng.normal(size=3 * n * n + n) / n)


@pytest.mark.parametrize("n", [2, 9])
@pytest.mark.parametrize("z", [0.7, np.nan])
@pytest.mark.parametrize("signals", [0, 2])
def test_an_update_is_differentiated_both_ways(n, z, signals):
    rng = np.random.default_rng(n)
    count = n * max(signals, 1) + n * n + n + 2
    both_ways(partial(measured, n=n, z=z, signals=signals), rng.normal(size=count) / 2)


@pytest.mark.parametrize("n", [3, 9])
def test_second_derivatives_are_right(n):
    """Each way after each way; the two steps in turn, as in a time loop."""
    rng = np.random.default_rng(n)
    root, h = jnp.asarray(rng.normal(size=(n, n))) / n, jnp.asarray(rng.normal(size=n))
    start = Estimate(h, root @ root.T)

    def both(point):
        point = jnp.concatenate([point, jnp.ones(n - 3)])
        estimate, F = start, jnp.eye(n) + jnp.outer(point, h) / 4
        for z in (0.3, -0.8):
            estimate = predict(estimate, F, jnp.eye(n) * point[0] ** 2)
            estimate, innovation = update(estimate, h + point, point[1] ** 2 + 1, z)
        return weighed((estimate, innovation))

    point = rng.normal(size=3)
    slope = jax.jit(jax.grad(both))
    numeric = np.stack(
        [central_difference(lambda at, i=i: float(slope(at)[i]), point, 1e-5) for i in range(3)]
    )
    scale = np.abs(numeric).max()
    for one, other in (
        (jax.jacfwd, jax.jacfwd),
        (jax.jacfwd, jax.jacrev),
        (jax.jacrev, jax.jacfwd),
    ):
        found = jax.jit(one(other(both)))(point)
        np.testing.assert_allclose(found, numeric, rtol=0, atol=DIFFERENCES * scale)


def test_known_parts_take_no_part_in_the_way_back():
    """Where F and h are known, a prediction keeps nothing and an update one row for each."""
    n = 9
    rng = np.random.default_rng(0)
    F, P, h = rng.normal(size=(n, n)), covariance(rng, n, n), rng.normal(size=n)

    def pull(P):
        ahead = predict(Estimate(jnp.zeros(n), P), F, jnp.eye(n))
        return jax.vjp(lambda P: update(Estimate(ahead.x, P), h, 1.0, 2.0), P)[1]

    kept = jax.tree.leaves(jax.eval_shape(pull, P))
    assert sum(leaf.size for leaf in kept if leaf.size > n) == 0


def together(point, n, m, z):
    """A weighted sum of all that rows taken together give, by x, a root of P, rows and r."""
    x, root, rows, r = jnp.split(point, np.cumsum([n, n * n, n * m]))
    root = root.reshape(n, n)
    taken = update_rows(Estimate(x, root @ root.T), rows.reshape(m, n), jnp.exp(r), z)
    return weighed(taken)


@pytest.mark.parametrize("missing", [(), (1,)])
def test_rows_together_are_rows_one_after_another(missing):
    n, m = 9, 4
    rng = np.random.default_rng(5)
    z = np.where(np.isin(np.arange(m), missing), np.nan, rng.normal(size=m))
    start = Estimate(rng.normal(size=n), covariance(rng, n, n))
    H, r = rng.normal(size=(m, n)), rng.uniform(0.1, 1, m)
    estimate, parts = start, []
    for i in range(m):
        estimate, innovation = update(estimate, H[i], r[i], z[i])
        parts.append(innovation)
    found, taken = update_rows(start, H, r, z)
    for ours, wanted in zip(found, estimate, strict=True):
        np.testing.assert_allclose(ours, wanted, rtol=0, atol=ORDER * np.abs(wanted).max())
    for ours, wanted in zip(taken, zip(*parts, strict=True), strict=True):
        np.testing.assert_allclose(ours, np.stack(wanted), rtol=0, atol=ORDER * 10)
    both_ways(partial(together, n=n, m=m, z=z), rng.normal(size=n + n * n + n * m + m) / 2)


def test_a_precise_measurement_that_is_repeated_keeps_its_digits():
    """Variance of the second: h P h' after the first is r s / (s + r), far below P's rounding."""
    n, r = 9, 1e-6
    h = np.random.default_rng(1).normal(size=n)
    _, taken = update_rows(
        Estimate(np.zeros(n), np.eye(n) * 1e8), np.stack([h, h]), r + np.zeros(2), np.zeros(2)
    )
    s = 1e8 * (h @ h)
    np.testing.assert_allclose(taken.variance, [s + r, r + r * s / (s + r)], rtol=1e-12)


def test_ways_back_are_the_transposed_derivatives():
    """Of a record with missing samples, by all of a model: backwards, forwards and twice."""
    n, m, N = 9, 2, 12
    rng = np.random.default_rng(7)
    z = np.where(rng.random((N, m)) < 0.3, np.nan, rng.normal(size=(N, m)))
    F, H = np.linalg.qr(rng.normal(size=(n, n)))[0] * 0.9, rng.normal(size=(m, n))

    def last(at, over):
        root = jnp.eye(n) + at[:n, None] * at[None, :n]
        step = Transition(F + 0.1 * jnp.outer(at[:n], at[:n]), jnp.eye(n), root @ root.T)
        model = LinearModel(step, H + at[n], jnp.exp(at[n + 1 :]), jnp.eye(n), at[:n])
        state, outputs = over(LinearKalman(), model, Sample(jnp.asarray(z)))
        return weighed((state, outputs.innovation, outputs.variance, outputs.gain))

    at = jnp.asarray(rng.normal(size=n + 1 + m)) / 4
    forth = jax.jit(jax.jacfwd(partial(last, over=run)))(at)
    back = jax.jit(jax.grad(partial(last, over=run_kept)))(at)
    np.testing.assert_allclose(back, forth, rtol=0, atol=1e-12 * np.abs(forth).max())
    second = jax.jit(jax.jacfwd(jax.grad(partial(last, over=run_kept))))(at)
    wanted = jax.jit(jax.jacfwd(jax.jacfwd(partial(last, over=run))))(at)
    np.testing.assert_allclose(second, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())
