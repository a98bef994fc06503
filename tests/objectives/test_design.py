"""Poles, settling times, squared error and variance of designs against textbook numbers."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import quad
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

START = jnp.array([1.0, 0.0, 0.0])
every_form = pytest.mark.parametrize("form", oracle.DESIGNS)


def error(gains):
    """The conventional loop's error (eps, e, dV), gains (K1, K2', K3)."""
    K1, K2, K3 = gains
    zero = 0.0 * K1
    return jnp.array([[zero, K3, zero], [zero, -K1, zero + 1], [zero - 1, -K2, zero]])


def scaled(form):
    return jnp.array(oracle.scaled_to_bound(oracle.DESIGNS[form].shape, 1.0))


@jax.jit
def settles(A, band):
    return settling_time(A, START, START, band)


@jax.jit
def areas(A):
    noise = jnp.diag(jnp.array([0.0, 0.0, 1.0]))
    return ise(A, START, START), steady_variance(A, noise, START)


@every_form
def test_all_printed_digits(form):
    printed, gains = oracle.DESIGNS[form], scaled(form)
    assert [float(gain) for gain in gains] == [as_printed(text) for text in printed.gains]
    A = error(gains)
    area, variance = areas(A)
    assert float(area) == as_printed(printed.ise)
    assert float(settles(A, 0.05)) == as_printed(printed.settling_5)
    assert float(settles(A, 0.02)) == as_printed(printed.settling_2)
    assert float(variance) == pytest.approx(1.0, rel=1e-12)


def test_worked_case_of_the_paper():
    gains = jnp.array(oracle.triple_pole_gains(0.01))
    assert float(settles(error(gains), 0.02)) == as_printed(oracle.SETTLING_2_WORKED)


@jax.jit
def judged(A, x0, c):
    return decay_rate(A), ise(A, x0, c), settling_time(A, x0, c, 0.02)


@pytest.mark.parametrize("seed", range(4))
def test_random_systems(seed):
    draw = np.random.default_rng(seed)
    A = draw.normal(size=(4, 4))
    A -= (np.linalg.eigvals(A).real.max() + 0.3) * np.eye(4)
    x0, c = draw.normal(size=4), draw.normal(size=4)
    rate, area, t = map(float, judged(A, x0, c))
    assert rate == pytest.approx(0.3, rel=1e-9)
    F = expm(0.1 * A)
    assert float(spectral_radius(jnp.asarray(F))) == pytest.approx(np.exp(-0.03), rel=1e-12)

    def output(t):
        return c @ expm(A * t) @ x0

    # e^(-0.6 t) has fallen to 1e-16 after 60 s
    parts = (quad(lambda t: output(t) ** 2, a, a + 5, epsabs=1e-13)[0] for a in range(0, 60, 5))
    assert area == pytest.approx(sum(parts), rel=1e-9)
    level = 0.02 * abs(c @ x0)
    assert abs(output(t)) == pytest.approx(level, rel=1e-9)
    later = t + np.linspace(1e-3, 40.0, 4001)
    assert max(abs(output(s)) for s in later) < level


MEASURES = {
    "ise": lambda g: ise(error(g), START, START),
    "settling": lambda g: settling_time(error(g), START, START, 0.02),
    "variance": lambda g: steady_variance(error(g), jnp.diag(jnp.array([0.0, 0.0, 1.0])), START),
    "decay": lambda g: decay_rate(error(g)),
}


@pytest.mark.parametrize("name", MEASURES)
def test_gradients_are_those_of_differences(name):
    # Not of the triple pole: where poles meet, the slowest has no gradient.
    gains, steps = scaled("Bessel"), 1e-5 * jnp.diag(scaled("Bessel"))
    around = jnp.concatenate([gains + steps, gains - steps])
    values, slopes = jax.jit(jax.vmap(jax.value_and_grad(MEASURES[name])))(around)
    # Differences over 1e-5 lose half of the digits; slopes are averaged over both ends.
    expected = (values[:3] - values[3:]) / 2e-5
    found = jnp.diagonal((slopes[:3] + slopes[3:]) / 2) * gains
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6)


def test_unstable_designs_have_no_finite_score():
    A = error(jnp.array([1.0, 1.0, 2.0]))  # K1 K2' < K3
    assert float(decay_rate(A)) < 0
    assert float(settles(A, 0.02)) == np.inf
    assert np.isnan(areas(A)).all()


def test_batches_are_the_single_ones():
    batch = jnp.stack([scaled(form) for form in oracle.DESIGNS])
    together = jax.jit(jax.vmap(lambda g: settling_time(error(g), START, START, 0.05)))(batch)
    alone = [float(settles(error(g), 0.05)) for g in batch]
    np.testing.assert_allclose(together, alone, rtol=1e-12)


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
