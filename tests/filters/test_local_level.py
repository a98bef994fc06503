"""The local level against least squares over the whole record and the Riccati equation."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

from filters import LevelSample, LocalLevel, LocalLevelNoise, Timed, TimedSample, run
from objectives import Data, InnovationLikelihood, score
from tests.oracles import diffuse_estimates

compiled = jax.jit(run, static_argnums=0)
N = 12


def record(seed):
    rng = np.random.default_rng(seed)
    z = 300.0 + np.cumsum(rng.normal(size=N))
    z[rng.random(N) < 0.3] = np.nan
    return z, rng.uniform(0.5, 2.0, N), rng.uniform(0.2, 3.0, N)


@given(st.integers(0, 2**32 - 1))
def test_it_is_least_squares_over_the_record(seed):
    z, sigma, dt = record(seed)
    q, R = 0.3, 2.0
    inputs = TimedSample(jnp.asarray(dt), LevelSample(jnp.asarray(z), jnp.asarray(sigma)))
    out = compiled(Timed(LocalLevel(1.0)), LocalLevelNoise(q, R), inputs)[1]
    W = q * dt[:, None, None]
    x, P = diffuse_estimates(np.ones((N, 1, 1)), W, np.ones(1), R * sigma**2, z)
    known = ~np.isnan(x[:, 0])
    # Least squares by normal equations keep ten digits at these conditions.
    np.testing.assert_allclose(out.level[known], x[known, 0], rtol=1e-10)
    counts = np.append(False, known[:-1]) & ~np.isnan(z)
    predicted = np.append(np.nan, x[:-1, 0])
    variance = np.append(np.nan, P[:-1, 0, 0]) + W[:, 0, 0] + R * sigma**2
    assert ((np.asarray(out.variance)[:, 0] > 0) == counts).all()
    np.testing.assert_allclose(out.variance[counts, 0], variance[counts], rtol=1e-9)
    np.testing.assert_allclose(out.innovation[counts, 0], (z - predicted)[counts], atol=1e-8)
    assert (np.asarray(out.innovation)[~counts] == 0).all()


def test_a_deviation_that_is_not_positive_is_a_missing_measurement():
    z, noise = jnp.array([1.0, 2.0, 3.0]), LocalLevelNoise(0.3, 2.0)
    for wrong in (0.0, -1.0, np.nan):
        given_it = compiled(LocalLevel(1.0), noise, LevelSample(z, jnp.array([1.0, wrong, 1.0])))
        holed = compiled(LocalLevel(1.0), noise, LevelSample(z.at[1].set(np.nan), jnp.ones(3)))
        for one, other in zip(jax.tree.leaves(given_it), jax.tree.leaves(holed), strict=True):
            np.testing.assert_array_equal(one, other)


def test_data_in_another_unit_give_the_same_in_that_unit():
    """To the bit where the unit is a power of two, however small."""
    z = jnp.asarray(record(1)[0])
    unit = 2.0**-35
    one = compiled(LocalLevel(0.1), LocalLevelNoise(0.3, 2.0), LevelSample(z))[1]
    other = compiled(
        LocalLevel(0.1), LocalLevelNoise(0.3 * unit**2, 2.0 * unit**2), LevelSample(unit * z)
    )[1]
    np.testing.assert_array_equal(unit * one.level, other.level)
    np.testing.assert_array_equal(unit**2 * one.variance, other.variance)


@pytest.mark.parametrize("ratio", [1e-12, 1e-3, 1.0, 1e6])
def test_the_steady_gain_solves_the_riccati_equation(ratio):
    one = np.eye(1)
    filter, noise = LocalLevel(0.25), LocalLevelNoise(jnp.array(4 * ratio), jnp.array(1.0))
    derived = filter.derive(noise)
    M = scipy.linalg.solve_discrete_are(one, one, ratio * one, one)[0, 0]
    assert float(derived["Q"]) == ratio
    assert float(derived["K"]) == pytest.approx(M / (M + 1), rel=1e-9)  # SciPy's, at 1e-12
    assert derived.keys() == filter.derived.keys()


def test_the_likelihood_finds_what_made_the_data():
    rng = np.random.default_rng(7)
    q, R, dt, samples = 2.0, 0.5, 0.1, 4000
    z = np.cumsum(np.sqrt(q * dt) * rng.normal(size=samples)) + np.sqrt(R) * rng.normal(
        size=samples
    )
    data = Data(LevelSample(jnp.asarray(z)), jnp.zeros(samples))

    @jax.jit
    def at(q, R):
        return score(LocalLevel(dt), InnovationLikelihood(), LocalLevelNoise(q, R), data)

    best = float(at(q, R))
    # A factor 1.5 is more than three deviations of either estimate at this length.
    for factor in (1 / 1.5, 1.5):
        assert best < min(float(at(factor * q, R)), float(at(q, factor * R)))
