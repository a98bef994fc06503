"""Poles, settling times, squared error and variance of designs against textbook numbers."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import expm

from filters import Uncertainty
from objectives import (
    VarianceRatio,
    decay_rate,
    ise,
    settling_time,
    spectral_radius,
    steady_variance,
)
from tests import oracles_ha1981 as oracle
from tests.published import as_printed

# Without the compiler's optimisation, which changes no formula and takes a third of the time.
quickly = partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})
START = jnp.array([1.0, 0.0, 0.0])
every_form = pytest.mark.parametrize("form", oracle.DESIGNS)


def error(gains):
    """The conventional loop's error (eps, e, dV), gains (K1, K2', K3)."""
    K1, K2, K3 = gains
    zero = 0.0 * K1
    return jnp.array([[zero, K3, zero], [zero, -K1, zero + 1], [zero - 1, -K2, zero]])


def scaled(form):
    return jnp.array(oracle.scaled_to_bound(oracle.DESIGNS[form].shape, 1.0))


MEASURES = {
    "decay": lambda A, x0, c, band: decay_rate(A),
    "ise": lambda A, x0, c, band: ise(A, x0, c),
    "settling": settling_time,
    "variance": lambda A, x0, c, band: steady_variance(A, jnp.diag(jnp.array([0.0, 0, 1])), c),
}


@quickly
def judged(A, x0, c, band):
    """Each measure and its gradient in A; compiled once, for three states."""
    return {name: jax.value_and_grad(of)(A, x0, c, band) for name, of in MEASURES.items()}


def measured(A, band=0.02, x0=START, c=START):
    return {name: float(value) for name, (value, _) in judged(A, x0, c, band).items()}


@every_form
def test_all_printed_digits(form):
    printed, gains = oracle.DESIGNS[form], scaled(form)
    assert [float(gain) for gain in gains] == [as_printed(text) for text in printed.gains]
    A = error(gains)
    found = measured(A)
    assert found["ise"] == as_printed(printed.ise)
    assert measured(A, 0.05)["settling"] == as_printed(printed.settling_5)
    assert found["settling"] == as_printed(printed.settling_2)
    assert found["variance"] == pytest.approx(1.0, rel=1e-12)


def test_worked_case_of_the_paper():
    gains = jnp.array(oracle.triple_pole_gains(0.01))
    assert measured(error(gains))["settling"] == as_printed(oracle.SETTLING_2_WORKED)


@pytest.mark.parametrize("seed", range(4))
def test_random_systems(seed):
    draw = np.random.default_rng(seed)
    A = draw.normal(size=(3, 3))
    A -= (np.linalg.eigvals(A).real.max() + 0.3) * np.eye(3)
    x0, c = draw.normal(size=3), draw.normal(size=3)
    found = measured(A, 0.02, x0, c)
    assert found["decay"] == pytest.approx(0.3, rel=1e-9)
    F = expm(0.1 * A)
    assert float(spectral_radius(jnp.asarray(F))) == pytest.approx(np.exp(-0.03), rel=1e-12)

    # Gauss's rule on pieces of 0.5 s; e^(-0.6 t) has fallen to 1e-16 after 60 s
    nodes, weights = np.polynomial.legendre.leggauss(20)
    inside = c @ expm(A * 0.25 * (nodes + 1)[:, None, None])
    area = 0.25 * sum(weights @ (inside @ x) ** 2 for x in samples(A, x0, 0.5, 120))
    assert found["ise"] == pytest.approx(area, rel=1e-9)
    level = 0.02 * abs(c @ x0)
    x = expm(A * found["settling"]) @ x0
    assert abs(c @ x) == pytest.approx(level, rel=1e-9)
    later = samples(A, expm(A * 1e-3) @ x, 0.01, 4001)
    assert np.abs(later @ c).max() < level


def samples(A, x, dt, count):
    """x and where it moves to, every dt."""
    F, states = expm(A * dt), [x]
    while len(states) < count:
        states.append(F @ states[-1])
    return np.array(states)


@pytest.mark.parametrize("name", MEASURES)
def test_gradients_are_those_of_differences(name):
    # Not of the triple pole: where poles meet, the slowest has no gradient.
    gains = scaled("Bessel")
    for i in range(3):
        step = 1e-5 * gains * jnp.eye(3)[i]
        ahead, behind = error(gains + step), error(gains - step)
        (up, slope_up), (down, slope_down) = (
            judged(A, START, START, 0.02)[name] for A in (ahead, behind)
        )
        # Differences over 1e-5 lose half of the digits; slopes are averaged over both ends.
        along = (ahead - behind) / 2e-5
        found = ((slope_up + slope_down) / 2 * along).sum()
        np.testing.assert_allclose(found, (up - down) / 2e-5, rtol=1e-5, atol=1e-6)


def test_unstable_designs_have_no_finite_score():
    found = measured(error(jnp.array([1.0, 1.0, 2.0])))  # K1 K2' < K3
    assert found["decay"] < 0
    assert found["settling"] == np.inf
    assert np.isnan([found["ise"], found["variance"]]).all()


def test_batches_are_the_single_ones():
    batch = jnp.stack([error(scaled(form)) for form in oracle.DESIGNS])
    each = jax.value_and_grad(lambda A: settling_time(A, START, START, 0.05))
    together = quickly(jax.vmap(each))(batch)
    for k, A in enumerate(batch):
        value, slope = judged(A, START, START, 0.05)["settling"]
        np.testing.assert_allclose(together[0][k], value, rtol=1e-12)
        size = np.abs(slope).max()
        np.testing.assert_allclose(together[1][k], slope, rtol=0, atol=1e-9 * size)


def test_discrete_variance():
    F, W, c = (
        np.array([[0.5, 0.2], [0.0, -0.7]]),
        np.array([[1.0, 0.3], [0.3, 2.0]]),
        np.array([1, 2.0]),
    )
    P = sum(np.linalg.matrix_power(F, k) @ W @ np.linalg.matrix_power(F, k).T for k in range(200))
    found = steady_variance(jnp.asarray(F), jnp.asarray(W), jnp.asarray(c), discrete=True)
    assert float(found) == pytest.approx(c @ P @ c, rel=1e-13)


def test_variance_ratio_is_a_geometric_mean():
    fold = VarianceRatio(state=1, samples=2)
    P = [jnp.diag(jnp.array([9.0, value])) for value in (5.0, 2.0, 8.0)]
    total = fold.init()
    for one, reference in zip(P, (np.nan, 1.0, 2.0), strict=True):
        total, kept = fold.update(
            total, Uncertainty(one, jnp.zeros((2, 1))), jnp.asarray(reference)
        )
        assert kept is None
    assert float(fold.value(total, None)) == pytest.approx(np.sqrt(2.0 * 4.0), rel=1e-15)
