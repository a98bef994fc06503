"""Factors of polynomials as coordinates, and gains that place the roots."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from objectives import Factors, place

_place = jax.jit(place)
sizes = st.floats(0.0, 50.0)


@given(degree=st.integers(1, 5), rate=st.floats(0.01, 0.99), discrete=st.booleans(), data=st.data())
def test_no_root_is_slower_than_asked(degree, rate, discrete, data):
    factors = Factors(degree, discrete)
    real = data.draw(sizes) if factors.odd else None
    pairs = [(data.draw(sizes), data.draw(sizes)) for _ in range(factors.pairs)]
    found = factors.coefficients(
        jnp.asarray(rate),
        None if real is None else jnp.asarray(real),
        [(jnp.asarray(d), jnp.asarray(f)) for d, f in pairs],
    )
    assert found.shape == (degree + 1,)
    assert float(found[0]) == pytest.approx(1.0, rel=1e-15)
    roots = np.roots(found)
    slowest = np.abs(roots).max() if discrete else roots.real.max()
    # Five roots that meet move by the fifth root of the rounding, 1e-3 of their size.
    assert slowest <= (rate if discrete else -rate) + 3e-3 * np.abs(roots).max()


def test_every_slow_polynomial_is_a_product_of_such_factors():
    # (s + 1) (s + 2) (s^2 + 3 s + 9) with a = 1: u = s + 1 gives u (u + 1) and u^2 + u + 7.
    pairs = [(jnp.asarray(d), jnp.asarray(f)) for d, f in ((1.0, 0.0), (1.0, 7.0))]
    found = Factors(4).coefficients(jnp.asarray(1.0), None, pairs)
    expected = np.polymul(np.poly([-1.0, -2.0]), [1.0, 3.0, 9.0])
    np.testing.assert_allclose(found, expected, rtol=1e-14)


@pytest.mark.parametrize("root", [0.5, 0.2, 0.0, -0.3])
def test_discrete_roots_anywhere_within_the_radius(root):
    t = (1 - 0.5) / (1 + 0.5)
    shape = (0.5 - root) / (0.5 + root) / t
    found = Factors(1, discrete=True).coefficients(jnp.asarray(0.5), jnp.asarray(shape), [])
    np.testing.assert_allclose(found, [1.0, -root], atol=1e-15)


def test_slow_discrete_factors_are_the_continuous_ones():
    # z = e^(s dt): with dt -> 0 both families have the same roots.
    dt, decay = 1e-3, 0.7
    one, pair = jnp.asarray(1.5), (jnp.asarray(0.4), jnp.asarray(2.0))
    continuous = Factors(3).coefficients(jnp.asarray(decay), one, [pair])
    radius = jnp.exp(-decay * dt)
    discrete = Factors(3, discrete=True).coefficients(radius, one, [pair])
    s, z = (np.sort_complex(np.roots(p)) for p in (continuous, discrete))
    np.testing.assert_allclose(np.sort_complex(np.log(z) / dt), s, rtol=1e-5)


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_coordinates_are_those_of_the_roots(degree, discrete):
    draw = np.random.default_rng(degree)
    for count in range(degree // 2 + 1):
        pairs = draw.uniform(-3, -1, count) + 1j * draw.uniform(0.1, 2, count)
        real = draw.uniform(-5, -1, degree - 2 * count)
        roots = np.concatenate([pairs, pairs.conj(), real])
        roots = np.exp(0.1 * roots) if discrete else roots
        rate = np.exp(-0.09) if discrete else 0.9
        factors = Factors(degree, discrete)
        alone, shapes = factors.coordinates(rate, roots)
        assert min([alone or 0.0, *np.ravel(shapes)]) >= 0
        spread = None if alone is None else jnp.asarray(alone)
        found = factors.coefficients(
            jnp.asarray(rate), spread, [(jnp.asarray(d), jnp.asarray(f)) for d, f in shapes]
        )
        np.testing.assert_allclose(found, np.poly(roots).real, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5])
def test_gains_put_the_poles_where_asked(n):
    draw = np.random.default_rng(n)
    A, C = draw.normal(size=(n, n)), draw.normal(size=n)
    wanted = -1.0 - np.arange(n) / 2
    L = np.asarray(_place(A, C, np.poly(wanted)))
    found = np.sort(np.linalg.eigvals(A - np.outer(L, C)).real)
    np.testing.assert_allclose(found, np.sort(wanted), rtol=1e-7)


def test_units_of_states_do_not_hide_them():
    A, C = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([0, 0, 1.0])
    units = np.array([1e-8, 1e-3, 1e5])
    wanted = np.poly([-1.0, -2, -3])
    L = np.asarray(_place(A, C, wanted))
    other = np.asarray(_place(A * units[:, None] / units, C / units, wanted))
    np.testing.assert_allclose(other, units * L, rtol=1e-9)


def test_what_is_not_seen_is_not_placed():
    L = _place(np.diag([-1.0, -2.0]), np.array([1.0, 0.0]), np.poly([-3.0, -4.0]))
    assert not np.isfinite(L).all()
