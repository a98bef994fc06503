"""Constant gains against a plain loop, the roots of their polynomial, and Kalman's steady state."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import (
    AlphaBeta,
    AlphaBetaGains,
    AlphaBetaGamma,
    AlphaBetaGammaGains,
    ConstantVelocity,
    ConstantVelocityNoise,
    run,
)

compiled = jax.jit(run, static_argnums=0)
DT = 0.2
TWO = AlphaBeta(DT), AlphaBetaGains(jnp.array(0.6), jnp.array(0.3))
THREE = AlphaBetaGamma(DT), AlphaBetaGammaGains(jnp.array(0.6), jnp.array(0.3), jnp.array(0.1))
both = pytest.mark.parametrize(("filter", "gains"), [TWO, THREE], ids=["two", "three"])


def matrices(gains):
    """F and K as they are printed."""
    n = len(gains)
    F = np.array([[1, DT, DT**2 / 2], [0, 1, DT], [0, 0, 1]])[:n, :n]
    return F, (np.array(gains) / np.array([1, DT, 2 * DT**2])[:n])


@both
def test_it_is_the_textbook_loop(filter, gains):
    z = np.random.default_rng(2).normal(size=30)
    z[[0, 7, 8]] = np.nan
    F, K = matrices(gains)
    x, xs, ys = None, [], []
    for sample in z:
        y = 0.0
        if x is not None:
            x = F @ x
            if not np.isnan(sample):
                y = sample - x[0]
                x = x + K * y
        elif not np.isnan(sample):
            x = np.eye(len(K))[0] * sample
        xs.append(np.zeros(len(K)) if x is None else x)
        ys.append(y)
    out = compiled(filter, gains, jnp.asarray(z))[1]
    np.testing.assert_allclose(np.stack(out[:-1], axis=1), xs, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(out.innovation[:, 0], ys, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(filter.derive(gains)["K"], K, rtol=1e-15)
    assert filter.derive(gains).keys() == filter.derived.keys()


def radius(gains):
    F, K = matrices(gains)
    return np.abs(np.linalg.eigvals(F - np.outer(K, F[0]))).max()


@pytest.mark.parametrize("alpha", [0.05, 0.5, 0.95, 1.5])
def test_it_is_stable_where_the_page_says(alpha):
    """Just inside and just outside of each border; 1e-3 of it is 1e-4 of a radius at least."""
    assert (
        radius((alpha, (4 - 2 * alpha) * (1 - 1e-3))) < 1 < radius((alpha, (4 - 2 * alpha) * 1.001))
    )
    beta = 0.4 * (4 - 2 * alpha)
    border = 4 * alpha * beta / (2 - alpha)
    assert radius((alpha, beta, border * (1 - 1e-3))) < 1 < radius((alpha, beta, border * 1.001))


def test_the_declared_ranges_are_stable():
    alpha, beta = AlphaBetaGains.__annotations__["alpha"], AlphaBetaGains.__annotations__["beta"]
    (low, high), (least, most) = (
        (f.__metadata__[0].low, f.__metadata__[0].high) for f in (alpha, beta)
    )
    for a in np.linspace(low, high, 9)[1:-1]:
        for b in np.linspace(least, most, 9)[1:-1]:
            assert radius((a, b)) < 1


@pytest.mark.parametrize("ratio", [1e-4, 1.0, 1e3])
def test_its_tracking_index_is_that_of_the_noise_with_these_steady_gains(ratio):
    K = ConstantVelocity(DT).derive(
        ConstantVelocityNoise(jnp.array(ratio * 5.0 / DT**3), jnp.array(5.0))
    )["K"]
    gains = AlphaBetaGains(K[0], K[1] * DT)
    assert float(AlphaBeta(DT).derive(gains)["tracking_index"]) ** 2 == pytest.approx(ratio)
