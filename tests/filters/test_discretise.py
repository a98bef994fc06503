"""From continuous to discrete: matrix exponential, noise integral, varying sample times."""

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
import scipy.linalg

from filters import transitions, van_loan
from tests.oracles import central_difference

discrete = jax.jit(van_loan)

OSCILLATOR = np.array([[0.0, 1.0], [-2.0, -0.4]])
UNSTABLE = np.array([[0.1, 1.0], [0.5, 0.3]])
DECAY = np.array([[0.0, 1.0], [0.0, -100.0]])  # a position, and a velocity that dies out in 10 ms


def by_quadrature(A, G, S, dt):
    """Integral of expm(A t) G S G' expm(A t)' over one step, Gauss-Legendre with 40 nodes."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total = np.zeros_like(A)
    for node, weight in zip((nodes + 1) * dt / 2, weights * dt / 2, strict=True):
        entered = scipy.linalg.expm(A * node) @ G
        total += weight * entered @ S @ entered.T
    return total


@pytest.mark.parametrize("A", [OSCILLATOR, UNSTABLE, np.zeros((2, 2))], ids=["osc", "unst", "zero"])
@pytest.mark.parametrize("dt", [1e-4, 0.1, 2.0])
@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e9])
def test_van_loan_is_the_exponential_and_the_noise_integral(A, dt, unit):
    G, S = np.array([[0.2, 1.0], [1.0, 0.0]]), unit * np.array([[2.0, 0.5], [0.5, 1.0]])
    step = discrete(A, G, S, dt)
    # Forty nodes are exact here; two exponentials of a few squarings each are left.
    np.testing.assert_allclose(step.F, scipy.linalg.expm(A * dt), rtol=0, atol=1e-14 * 4)
    np.testing.assert_allclose(step.Q, by_quadrature(A, G, S, dt), rtol=1e-12)
    np.testing.assert_array_equal(step.G, np.eye(2))
    np.testing.assert_array_equal(step.Q, step.Q.T)


@pytest.mark.parametrize("dt", [1e-4, 1.0, 50.0])
def test_double_integrator_in_closed_form(dt):
    A, G, q = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), 0.7
    step = discrete(A, G, np.array([[q]]), dt)
    np.testing.assert_allclose(step.F, [[1, dt], [0, 1]], rtol=1e-14)
    expected = [[q * dt**3 / 3, q * dt**2 / 2], [q * dt**2 / 2, q * dt]]
    np.testing.assert_allclose(step.Q, expected, rtol=1e-13)  # six doublings at dt = 50


@pytest.mark.parametrize("dt", [1e-3, 0.1, 0.5, 10.0, 1000.0])
def test_a_step_much_longer_than_a_time_constant(dt):
    """expm(-A dt) is e^50 at 0.5 s and overflows at 10 s; the closed form has no such term."""
    step = discrete(DECAY, np.array([[0.0], [1.0]]), np.eye(1), dt)
    with mpmath.workdps(50):
        a, t = mpmath.mpf(100), mpmath.mpf(dt)
        gone = mpmath.exp(-a * t)
        q11 = (t - 2 * (1 - gone) / a + (1 - gone**2) / (2 * a)) / a**2
        q12, q22 = (1 - gone) ** 2 / (2 * a**2), (1 - gone**2) / (2 * a)
        F = [[1, float((1 - gone) / a)], [0, float(gone)]]
        Q = [[float(q11), float(q12)], [float(q12), float(q22)]]
    # 17 doublings at 1000 s, each of which may lose one unit in the last place
    np.testing.assert_allclose(step.F, F, rtol=1e-13, atol=1e-18)
    np.testing.assert_allclose(step.Q, Q, rtol=1e-13)


def test_covariance_is_positive_over_any_step():
    G, S = np.array([[1.0], [0.0]]), np.eye(1)
    for dt in (1e-6, 1e-2, 1.0, 1e3):
        Q = np.asarray(discrete(OSCILLATOR, G, S, dt).Q)
        assert np.linalg.eigvalsh(Q).min() >= -1e-15 * np.abs(Q).max()


def test_two_half_steps_are_one_step():
    G, S = np.eye(2), np.array([[1.0, 0.2], [0.2, 3.0]])
    half, whole = discrete(OSCILLATOR, G, S, 0.7), discrete(OSCILLATOR, G, S, 1.4)
    np.testing.assert_allclose(half.F @ half.F, whole.F, rtol=1e-13)  # some ten products
    np.testing.assert_allclose(half.F @ half.Q @ half.F.T + half.Q, whole.Q, rtol=1e-13)


@jax.jit
@jax.value_and_grad
def total(point):
    """One number of F and Q, from A, the density and dt."""
    A, s, dt = point[:4].reshape(2, 2), point[4], point[5]
    step = van_loan(A, jnp.eye(2), s * jnp.eye(2), dt)
    return (step.F**2).sum() + (step.Q * jnp.array([[1.0, 2.0], [0.0, 3.0]])).sum()


@pytest.mark.parametrize("dt", [0.2, 3.1])  # the step whole, and in eight parts
def test_gradient_equals_central_differences(dt):
    point = np.array([0.0, 1.0, -2.0, -0.4, 0.3, dt])
    difference = central_difference(lambda p: total(p)[0], point, 1e-5)
    # h = 1e-5: h^2 = 1e-10 of truncation times third derivatives of order dt^3 = 30
    np.testing.assert_allclose(total(point)[1], difference, rtol=1e-7, atol=1e-8)


def test_gradient_at_rest_is_finite():
    """A = 0, S = 0 and dt = 0 are corners of the way the step is divided."""
    for point in (np.zeros(6), np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.1])):
        assert np.isfinite(total(point)[1]).all()


def test_transitions_give_each_sample_its_step():
    G, S = np.eye(2), 0.3 * np.eye(2)
    dt = np.array([0.1, 0.0, 0.25, 0.1, 0.0])
    steps = transitions(jnp.asarray(OSCILLATOR), jnp.asarray(G), jnp.asarray(S), dt)
    assert steps.F.shape == steps.G.shape == steps.Q.shape == (5, 2, 2)
    for k, time in enumerate(dt):
        np.testing.assert_allclose(
            steps.F[k], scipy.linalg.expm(OSCILLATOR * time), rtol=0, atol=1e-15 * 4
        )
        np.testing.assert_allclose(
            steps.Q[k], by_quadrature(OSCILLATOR, G, S, time), rtol=1e-12, atol=1e-300
        )
    np.testing.assert_array_equal(steps.F[1], np.eye(2))
    np.testing.assert_array_equal(steps.Q[1], np.zeros((2, 2)))


@pytest.mark.parametrize(
    ("dt", "message"),
    [
        ([0.1, -0.1], r"dt has 1 entries .* the first -0.1 at sample 1"),
        ([np.nan, 0.1, np.inf], r"dt has 2 entries .* the first nan at sample 0"),
    ],
)
def test_transitions_refuse_time_that_runs_backwards(dt, message):
    with pytest.raises(ValueError, match=message):
        transitions(jnp.zeros((1, 1)), jnp.eye(1), jnp.eye(1), np.array(dt))
