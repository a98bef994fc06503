"""Constant velocity and acceleration against least squares, quadrature and Riccati equations."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

from filters import (
    ConstantAcceleration,
    ConstantAccelerationNoise,
    ConstantVelocity,
    ConstantVelocityNoise,
    PositionSample,
    Timed,
    TimedSample,
    run,
)
from tests.oracles import diffuse_estimates, integrated_noise

compiled = jax.jit(run, static_argnums=0)
N = 12
VELOCITY, ACCELERATION = ConstantVelocity(1.0), ConstantAcceleration(1.0)
NOISE = {VELOCITY: ConstantVelocityNoise, ACCELERATION: ConstantAccelerationNoise}
STATES = {VELOCITY: 2, ACCELERATION: 3}
both = pytest.mark.parametrize("filter", [VELOCITY, ACCELERATION], ids=["velocity", "acceleration"])


def noise(filter, q, R):
    return NOISE[filter](jnp.array(q), jnp.array(R))


def transition(n, dt):
    return scipy.linalg.expm(np.diag(np.ones(n - 1), 1) * dt)


def stacked(out, n):
    return np.stack([np.asarray(part)[:, 0] for part in out[:n]], axis=1)


@both
@given(seed=st.integers(0, 2**32 - 1))
def test_it_is_least_squares_over_the_record(filter, seed):
    """With varying times, missing samples, deviations of their own, and any start."""
    rng = np.random.default_rng(seed)
    n, q, R = STATES[filter], 0.3, 2.0
    dt, sigma = rng.uniform(0.5, 2.0, N), rng.uniform(0.5, 2.0, N)
    z = 1e3 * rng.normal() + 30 * rng.normal() * np.cumsum(dt) + rng.normal(size=N)
    z[rng.random(N) < 0.3] = np.nan
    inputs = PositionSample(jnp.asarray(z), sigma=jnp.asarray(sigma))
    out = compiled(Timed(filter), noise(filter, q, R), TimedSample(jnp.asarray(dt), inputs))[1]
    F = np.array([transition(n, t) for t in dt])
    W = np.array([integrated_noise(n, q, t) for t in dt])
    h = np.eye(n)[0]
    x, P = diffuse_estimates(F, W, h, R * sigma**2, z)
    known = ~np.isnan(x[:, 0])
    # The grid of integrated_noise leaves 1e-9, and normal equations as much.
    np.testing.assert_allclose(stacked(out, n)[known], x[known], rtol=1e-6, atol=1e-6)
    counts = np.append(False, known[:-1]) & ~np.isnan(z)
    assert ((np.asarray(out.variance)[:, 0] > 0) == counts).all()
    for k in np.flatnonzero(counts):
        s = h @ (F[k] @ P[k - 1] @ F[k].T + W[k]) @ h + R * sigma[k] ** 2
        assert float(out.variance[k, 0]) == pytest.approx(s, rel=1e-6)
        assert float(out.innovation[k, 0]) == pytest.approx(
            z[k] - h @ F[k] @ x[k - 1], rel=1e-6, abs=1e-6
        )


@both
def test_the_noise_is_what_the_derivative_s_noise_adds(filter):
    derived = type(filter)(0.7).derive(noise(filter, 3.0, 1.0))
    expected = integrated_noise(STATES[filter], 3.0, 0.7)
    np.testing.assert_allclose(derived["Q"], expected, rtol=1e-8)  # the grid's error
    assert derived.keys() == filter.derived.keys()


@both
@pytest.mark.parametrize("dt", [0.01, 2.0])
@pytest.mark.parametrize("ratio", [1e-6, 1e-2, 1.0, 1e4])
def test_the_steady_gains_solve_the_riccati_equation(filter, dt, ratio):
    """At q dt^(2 n - 1) / R = ratio; SciPy is asked in samples, where its answer has ten digits."""
    n = STATES[filter]
    F, W = transition(n, 1.0), integrated_noise(n, ratio, 1.0)
    M = scipy.linalg.solve_discrete_are(F.T, np.eye(n)[:, :1], W, np.eye(1))
    K = type(filter)(dt).derive(noise(filter, 5.0 * ratio / dt ** (2 * n - 1), 5.0))["K"]
    expected = M[:, 0] / (M[0, 0] + 1) / dt ** np.arange(n)
    np.testing.assert_allclose(K, expected, rtol=1e-6)


@both
def test_the_gains_settle_to_the_steady_ones(filter):
    """A sudden step of one unit in a long record moves the estimate by the gains."""
    n = STATES[filter]
    params = noise(filter, 0.2, 1.0)
    z = jnp.zeros(300).at[-1].set(1.0)
    out = compiled(filter, params, PositionSample(z))[1]
    np.testing.assert_allclose(stacked(out, n)[-1], filter.derive(params)["K"], rtol=1e-9)


@both
def test_data_in_another_unit_give_the_same_in_that_unit(filter):
    z = jnp.asarray(300 + np.random.default_rng(1).normal(size=N))
    unit = 2.0**-35
    one = compiled(filter, noise(filter, 0.3, 2.0), PositionSample(z))[1]
    params = noise(filter, 0.3 * unit**2, 2.0 * unit**2)
    other = compiled(filter, params, PositionSample(unit * z))[1]
    np.testing.assert_array_equal(unit * one.position, other.position)
    np.testing.assert_array_equal(unit**2 * one.variance, other.variance)


@both
def test_single_precision_stays_single_and_follows(filter):
    """At 1 kHz, where acceleration's variance over R is 1e13 at first, and in a tiny unit."""
    quick = type(filter)(1e-3)
    z = 1e-9 * np.sin(2 * np.pi * np.arange(3000) * 1e-3)
    q, R = (1e-14 if filter is VELOCITY else 1e-10), 1e-20
    params, inputs = noise(filter, q, R), PositionSample(jnp.asarray(z))
    whole = compiled(quick, params, inputs)[1]
    single = jax.tree.map(lambda leaf: leaf.astype(np.float32), (params, inputs))
    state, half = compiled(quick, *single)
    leaves = jax.tree.leaves((state, half, quick.derive(single[0])))
    assert {leaf.dtype for leaf in leaves} == {jnp.dtype("float32")}
    # Of numbers of order 1e-9; float32 has seven digits, of which the slow gains take three.
    np.testing.assert_allclose(half.position, whole.position, atol=1e-12)


@both
def test_axes_are_filters_of_their_own(filter):
    rng = np.random.default_rng(3)
    z = rng.normal(size=(N, 3))
    z[rng.random((N, 3)) < 0.3] = np.nan
    params = noise(filter, 0.3, 2.0)
    together = type(filter)(1.0, "xyz")
    out = compiled(together, params, PositionSample(*jnp.asarray(z.T)))[1]
    for axis in range(3):
        alone = compiled(filter, params, PositionSample(jnp.asarray(z[:, axis])))[1]
        for one, other in zip(out, alone, strict=True):
            np.testing.assert_allclose(one[:, axis], other[:, 0], rtol=1e-12, atol=1e-13)


@both
def test_two_measurements_at_one_time_are_one_of_their_mean(filter):
    params = noise(filter, 0.3, 2.0)
    dt, z = jnp.array([1.0, 0.0, 1.0, 1.0, 1.0]), jnp.array([1.0, 3.0, 5.0, 2.0, 1.0])
    twice = compiled(Timed(filter), params, TimedSample(dt, PositionSample(z)))[1]
    sigma = jnp.array([np.sqrt(0.5), 1.0, 1.0, 1.0])
    mean = PositionSample(jnp.array([2.0, 5.0, 2.0, 1.0]), sigma=sigma)
    once = compiled(Timed(filter), params, TimedSample(jnp.ones(4), mean))[1]
    np.testing.assert_allclose(twice.position[1:], once.position, rtol=1e-12)
    np.testing.assert_allclose(twice.variance[2:], once.variance[1:], rtol=1e-12)
    assert float(twice.variance[1, 0]) == 4.0  # it counts: the first predicted it


@both
def test_axes_have_to_be_those_of_the_samples(filter):
    x = jnp.ones(3)
    with pytest.raises(ValueError, match="made for 1 axes and the samples bring 2; give"):
        run(filter, noise(filter, 0.3, 2.0), PositionSample(x, x))
    assert filter.given(frozenset({"x", "y", "sigma"})).axes == "xy"
    assert filter.given(frozenset({"x"})) == filter
    for channels in (frozenset({"x", "z"}), frozenset({"sigma"})):
        with pytest.raises(ValueError, match=r"name the first one x"):
            filter.given(channels)
