"""The atoms predict, update and decorrelate against matrix formulas and exact arithmetic."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filters import Estimate, decorrelate, predict, update, update_large
from filters.small_linalg import matmul
from tests.oracles import exact_update, kalman_predict, kalman_update
from tests.strategies import covariance, seeds

take = jax.jit(update)
advance = jax.jit(predict)
split = jax.jit(decorrelate)

# The atoms and the oracle do the same few dozen operations in another order: some 10 units in the
# last place of the largest entry.
ROUNDING = 1e-13


def close(actual, expected, tolerance=ROUNDING):
    scale = max(np.abs(expected).max(), 1e-300)
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance * scale)


def is_covariance(P, scale):
    """Symmetric to the bit, and no eigenvalue below zero by more than its own rounding."""
    return np.array_equal(P, P.T) and np.linalg.eigvalsh(P).min() >= -1e-14 * scale


def all_at_once(estimate, H, R, z):
    """What the filter does with a sample: decorrelate, then one update after another."""
    rows, variances, values = split(H, R, z)
    innovations = []
    for h, r, value in zip(rows, variances, values, strict=True):
        estimate, innovation = take(estimate, h, r, value)
        innovations.append(innovation)
    return estimate, innovations


@pytest.mark.parametrize("n", [1, 3, 8, 9])  # matmul changes its way above 8
def test_predict_is_the_textbook_formula(n):
    rng = np.random.default_rng(n)
    x, P = rng.normal(size=n), covariance(rng, n, n)
    F, W = rng.normal(size=(n, n)), covariance(rng, n, n)
    expected = kalman_predict(x, P, F, W)
    for actual, wanted in zip(advance(Estimate(x, P), F, W), expected, strict=True):
        close(actual, wanted)


@pytest.mark.parametrize("n", [3, 9])
@pytest.mark.parametrize("right", ["vector", "matrix"])
@pytest.mark.parametrize("left", ["vector", "matrix"])
def test_matmul_is_the_matrix_product(left, right, n):
    rng = np.random.default_rng(n)
    A = rng.normal(size=(n,) if left == "vector" else (4, n))
    B = rng.normal(size=(n,) if right == "vector" else (n, 2))
    product = matmul(jnp.asarray(A), jnp.asarray(B))
    assert product.shape == (A @ B).shape
    close(product, A @ B)


@given(rng=seeds(), rank=st.integers(0, 3))
def test_update_is_the_textbook_formula(rng, rank):
    x, P, h = rng.normal(size=3), covariance(rng, 3, rank), rng.normal(size=3)
    r, z = rng.uniform(0.1, 2.0), rng.normal()
    after, innovation = take(Estimate(x, P), h, r, z)
    wanted_x, wanted_P = kalman_update(x, P, h[None], np.array([[r]]), np.array([z]))
    close(after.x, wanted_x)
    np.testing.assert_allclose(after.P, wanted_P, rtol=0, atol=ROUNDING * (1 + np.abs(P).max()))
    close(innovation.value, z - h @ x)
    close(innovation.variance, h @ P @ h + r)
    np.testing.assert_allclose(innovation.gain, P @ h / (h @ P @ h + r), rtol=1e-12)
    assert is_covariance(np.asarray(after.P), 1 + np.abs(P).max())


@pytest.mark.parametrize("r", [1e-12, 1e-6, 1.0])
@pytest.mark.parametrize("h", [[1.0, 0.0], [0.0, 1.0], [0.5, 2.0]])
def test_update_keeps_its_digits_where_P0_is_all_ones(h, r):
    """P0 = ones is of rank one, and (1 - K) P would be wrong by 1e-4 at r = 1e-12."""
    x, P, z = np.array([0.1, -0.3]), np.ones((2, 2)), 0.2
    after, _ = take(Estimate(x, P), np.array(h), r, z)
    wanted_x, wanted_P = exact_update(x, P, h, r, z)
    np.testing.assert_allclose(after.x, wanted_x, rtol=0, atol=3e-16)  # rounding of x, order 0.5
    np.testing.assert_allclose(after.P, wanted_P, rtol=1e-14)  # relative to P, which is 1e-12 small
    assert is_covariance(np.asarray(after.P), 1.0)


def test_update_never_leaves_the_covariances():
    """1000 precise measurements from a rank-one start: symmetric to the bit, no negative value."""

    def chain(estimate, h):
        estimate, _ = update(estimate, h, 1e-12, 0.0)
        return estimate, estimate.P

    rows = np.random.default_rng(3).normal(size=(1000, 3))
    _, Ps = jax.jit(lambda e: jax.lax.scan(chain, e, rows))(Estimate(np.zeros(3), np.ones((3, 3))))
    assert all(is_covariance(P, 1.0) for P in np.asarray(Ps))


@pytest.mark.parametrize("z", [np.nan, [np.nan, np.nan], [1.0, np.nan]], ids=str)
def test_missing_measurement_changes_nothing(z):
    z = np.asarray(z)
    x, P = np.ones((2, *z.shape)), np.array([[2.0, 0.5], [0.5, 1.0]])
    after, innovation = take(Estimate(x, P), np.array([1.0, 1.0]), 0.1, z)
    np.testing.assert_array_equal(after.x, x)
    np.testing.assert_array_equal(after.P, P)
    np.testing.assert_array_equal(innovation.value, np.zeros(z.shape))
    np.testing.assert_array_equal(innovation.gain, np.zeros(2))
    assert innovation.variance == 0


def test_several_signals_are_several_filters():
    rng = np.random.default_rng(4)
    x, P = rng.normal(size=(3, 4)), covariance(rng, 3, 3)
    h, z = rng.normal(size=3), rng.normal(size=4)
    F, W = rng.normal(size=(3, 3)), covariance(rng, 3, 1)
    together, innovation = take(advance(Estimate(x, P), F, W), h, 0.3, z)
    for i in range(4):
        alone, its = take(advance(Estimate(x[:, i], P), F, W), h, 0.3, z[i])
        close(together.x[:, i], alone.x)
        close(together.P, alone.P)
        close(innovation.value[i], its.value)


@given(rng=seeds())
def test_decorrelate_gives_a_diagonal_covariance(rng):
    """L^-1 R L^-T is diagonal; L^-1 is read off by sending R's factor through z and H."""
    R = covariance(rng, 3, 3) + 0.1 * np.eye(3)
    H = np.eye(3)
    rows, variances, values = split(H, R, np.ones(3))
    scale = np.abs(rows).max() ** 2 * np.abs(R).max()  # L^-1 amplifies the rounding of R
    np.testing.assert_allclose(rows @ R @ rows.T, np.diag(variances), atol=ROUNDING * scale)
    np.testing.assert_allclose(values, rows @ np.ones(3), atol=ROUNDING * np.abs(rows).max())
    np.testing.assert_allclose(np.prod(variances), np.linalg.det(R), rtol=1e-11)  # det L = 1


@pytest.mark.parametrize("hole", [(), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)], ids=str)
def test_missing_components_equal_dropped_rows(hole):
    rng = np.random.default_rng(5)
    x, P, H = rng.normal(size=3), covariance(rng, 3, 2), rng.normal(size=(3, 3))
    R, z = covariance(rng, 3, 3) + 0.1 * np.eye(3), rng.normal(size=3)
    z[list(hole)] = np.nan
    after, _ = all_at_once(Estimate(x, P), H, R, z)
    wanted_x, wanted_P = kalman_update(x, P, H, R, z)
    close(after.x, wanted_x, 1e-12)  # three dependent updates, R with a condition of some 100
    close(after.P, wanted_P, 1e-12)


def test_a_component_missing_in_one_signal_is_missing_in_all():
    rng = np.random.default_rng(6)
    R, H, z = covariance(rng, 2, 2) + np.eye(2), rng.normal(size=(2, 2)), rng.normal(size=(2, 3))
    z[0, 1] = np.nan
    _, _, values = split(H, R, z)
    assert np.isnan(values[0]).all()
    np.testing.assert_array_equal(values[1], z[1])


@given(rng=seeds(), order=st.permutations(range(4)), rank=st.integers(0, 3))
def test_order_of_independent_measurements_does_not_matter(rng, order, rank):
    x, P = rng.normal(size=3), covariance(rng, 3, rank)
    H, r, z = rng.normal(size=(4, 3)), rng.uniform(0.1, 2.0, 4), rng.normal(size=4)
    ends = []
    for indices in (range(4), order):
        estimate = Estimate(x, P)
        for i in indices:
            estimate, _ = take(estimate, H[i], r[i], z[i])
        ends.append(estimate)
    # Four updates whose gains are at most of order 10: two digits above rounding.
    scale = 1 + np.abs(P).max()
    np.testing.assert_allclose(ends[0].x, ends[1].x, atol=1e-13 * scale, rtol=1e-12)
    np.testing.assert_allclose(ends[0].P, ends[1].P, atol=1e-13 * scale)


@given(rng=seeds(), exponent=st.integers(-12, 12))
def test_scaling_all_covariances_leaves_the_estimate(rng, exponent):
    x, P = rng.normal(size=3), covariance(rng, 3, 2)
    h, r, z = rng.normal(size=3), rng.uniform(0.1, 2.0), rng.normal()
    c = 10.0**exponent
    one, _ = take(Estimate(x, P), h, r, z)
    other, _ = take(Estimate(x, c * P), h, c * r, z)
    close(other.x, one.x)
    np.testing.assert_allclose(other.P / c, one.P, atol=ROUNDING * (1 + np.abs(P).max()))


def test_gradient_through_a_missing_measurement_is_finite():
    def total(h, r, z):
        after, innovation = update(Estimate(jnp.ones(2), jnp.ones((2, 2))), h, r, z)
        return after.x.sum() + after.P.sum() + innovation.value

    gradient = jax.jit(jax.grad(total, argnums=(0, 1)))
    for z in (0.3, np.nan):
        assert all(np.isfinite(part).all() for part in gradient(np.array([1.0, 0.5]), 0.1, z))


def test_gradient_through_missing_components_of_a_full_R_is_finite():
    def total(R, z):
        rows, variances, values = decorrelate(jnp.eye(2), R, z)
        return rows.sum() + variances.sum() + jnp.nansum(values)

    gradient = jax.jit(jax.grad(total))
    for z in ([1.0, 2.0], [np.nan, 2.0], [1.0, np.nan], [np.nan, np.nan]):
        assert np.isfinite(gradient(np.array([[1.0, 0.4], [0.4, 2.0]]), np.array(z))).all()


@pytest.mark.parametrize("z", [0.7, np.nan])
@pytest.mark.parametrize("row", [3, "mixed"])
def test_the_update_of_many_states_is_the_update(row, z):
    """In values and, forwards and backwards, in derivatives."""
    rng = np.random.default_rng(15)
    root, mixed = rng.normal(size=(15, 15)), jnp.asarray(rng.normal(size=15))
    before = Estimate(jnp.asarray(rng.normal(size=15)), jnp.asarray(root @ root.T))
    h = mixed if row == "mixed" else row
    dense = mixed if row == "mixed" else jnp.eye(15)[row]

    def large(scale):
        return update_large(Estimate(before.x, scale * before.P), h, scale**2, jnp.asarray(z))

    def usual(scale):
        return update(Estimate(before.x, scale * before.P), dense, scale**2, jnp.asarray(z))

    for way in (lambda f: f, jax.jacfwd, jax.jacrev):
        for one, other in zip(
            *(jax.tree.leaves(jax.jit(way(f))(1.3)) for f in (large, usual)), strict=True
        ):
            # P is of order 15: other sums of 15 terms.
            np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-12)
