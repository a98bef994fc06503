"""The frequency view of a complementary filter against linear systems, and errors by phases."""

from functools import partial
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov
from scipy.signal import TransferFunction, freqresp

from filters import PiOutputs
from objectives import AngleRmse, ComplementaryLoop, Records, SensorNoise, masked
from tests.oracles_you_lee import K1, K2, gains, time_constants

QUICK = {"xla_backend_optimization_level": 0}
GAINS = [(K1, K2), (0.05, 0.0125), (0.0253, 0.0269), (2.0, 0.3)]


@partial(jax.jit, compiler_options=QUICK)
def shape(loop):
    return loop.damping, loop.natural_frequency, loop.poles


@partial(jax.jit, compiler_options=QUICK)
def steady(loop, error):
    return loop.bias_error(error), loop.ramp_error(error)


transfer = jax.jit(lambda loop, omega: loop.transfer(omega), compiler_options=QUICK)
predicted = jax.jit(lambda loop, noise: loop.variance(noise), compiler_options=QUICK)
rmse = jax.jit(AngleRmse(), compiler_options=QUICK)


def loop(k1, k2):
    return ComplementaryLoop(np.float64(k1), np.float64(k2))


def noise(rate=0.0, walk=0.0, angle=0.0):
    return SensorNoise(*map(np.float64, (rate, walk, angle)))


def lyapunov(A, density):
    """Variance of the first state."""
    return solve_continuous_lyapunov(A, -density)[0, 0]


def system(k1, k2):
    """Error and integral: e' = b + K1 (n - e) + i, i' = K1 K2 (n - e)."""
    return np.array([[-k1, 1.0], [-k1 * k2, 0.0]]), np.array([k1, k1 * k2])


# ------------------------------------------------------------------------------- the loop itself


def test_what_15_makes_of_a_time_constant():
    assert [float(gain) for gain in ComplementaryLoop.critical(jnp.array(25.0))] == [0.08, 0.02]
    assert [float(gain) for gain in ComplementaryLoop.critical(jnp.array(40.0))] == [0.05, 0.0125]
    assert tuple(map(float, ComplementaryLoop.critical(jnp.array(31.0)))) == gains(31.0)
    assert float(shape(loop(*gains(7.0)))[0]) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("pair", GAINS)
def test_poles_damping_and_frequency(pair):
    _, _, tau, zeta, roots = time_constants(*pair)
    damping, frequency, poles = shape(loop(*pair))
    assert float(damping) == pytest.approx(zeta, rel=1e-14)
    assert float(frequency) == pytest.approx(1 / tau, rel=1e-14)
    # a double pole is only known to the root of the rounding
    np.testing.assert_allclose(np.sort_complex(poles), np.sort_complex(roots), atol=3e-9)


def test_the_papers_poles():
    poles = np.asarray(shape(loop(K1, K2))[2]).real
    np.testing.assert_allclose(poles, [-0.0644949, -0.0155051], atol=5e-8)


@pytest.mark.parametrize("pair", [*GAINS, (0.1, 0.0)])
def test_transfers_are_those_of_the_polynomials(pair):
    k1, k2 = pair
    omega = np.geomspace(1e-4, 10.0, 9)
    bottom = [1.0, k1, k1 * k2] if k2 else [1.0, k1]
    tops = ([1.0, 0.0], [k1, k1 * k2]) if k2 else ([1.0], [k1])
    for top, found in zip(tops, transfer(loop(*pair), omega), strict=True):
        expected = freqresp(TransferFunction(top, bottom), omega)[1]
        np.testing.assert_allclose(found, expected, rtol=1e-11)


@pytest.mark.parametrize("pair", GAINS)
def test_variances_solve_the_lyapunov_equation(pair):
    A, draw = system(*pair)
    rate, walk, angle = 3e-4, 2e-7, 5e-2

    drift = np.zeros((3, 3))
    drift[:2, :2], drift[0, 2], drift[2, 2] = A, 1.0, -1e-9  # a walk that comes back at last
    by_rate = lyapunov(A, rate * np.outer([1.0, 0.0], [1.0, 0.0]))
    by_angle = lyapunov(A, angle * np.outer(draw, draw))
    by_walk = lyapunov(drift, np.diag([0.0, 0.0, walk]))
    found = loop(*pair)
    assert float(predicted(found, noise(rate=rate))) == pytest.approx(by_rate, rel=1e-12)
    assert float(predicted(found, noise(angle=angle))) == pytest.approx(by_angle, rel=1e-12)
    # the walk comes back with 1e-9/s, against poles of 1e-2/s
    assert float(predicted(found, noise(walk=walk))) == pytest.approx(by_walk, rel=1e-6)
    together = float(predicted(found, noise(rate, walk, angle)))
    assert together == pytest.approx(by_rate + by_angle + by_walk, rel=1e-6)


def test_steady_errors_are_those_of_the_equations():
    A, draw = system(K1, K2)
    # a bias is balanced by the integral; a ramp a leaves e with i' = -a, so e = a / (K1 K2)
    assert np.linalg.solve(A, [-0.3, 0.0])[0] == pytest.approx(0.0, abs=1e-15)
    assert np.linalg.solve(A, -draw)[0] == pytest.approx(1.0, rel=1e-14)
    bias, ramp = map(float, steady(loop(K1, K2), 0.3))
    assert bias == 0.0
    assert ramp == pytest.approx(np.linalg.solve(A, [0.0, -0.3])[0], rel=1e-14)


def test_first_order():
    found = ComplementaryLoop.first_order(np.float64(4.0))
    assert [float(gain) for gain in found] == [0.25, 0.0]
    assert [float(part) for part in shape(found)[:2]] == [np.inf, 0.0]
    assert [float(part) for part in steady(found, 0.1)] == pytest.approx([0.4, np.inf], rel=1e-15)
    assert float(steady(found, 0.0)[1]) == 0.0
    assert float(predicted(found, noise(walk=1e-9))) == np.inf
    by_hand = lyapunov(np.array([[-0.25]]), np.array([[2.0 + 0.25**2 * 3.0]]))
    assert float(predicted(found, noise(2.0, 0.0, 3.0))) == pytest.approx(by_hand, rel=1e-14)


def test_everything_has_a_derivative():
    """By both gains, K2 = 0 included."""

    def numbers(pair):
        found = ComplementaryLoop(*pair)
        seen = found.transfer(jnp.array(0.03))
        return jnp.stack(
            [
                found.natural_frequency,
                jnp.abs(seen.gyroscope),
                jnp.abs(seen.accelerometer),
                found.variance(SensorNoise(1e-4, 0.0, 1e-2)),
                found.bias_error(jnp.array(0.1)),
            ]
        )

    slopes = jax.jit(jax.jacfwd(numbers), compiler_options=QUICK)
    values = jax.jit(numbers, compiler_options=QUICK)
    assert np.isfinite(slopes(np.array([0.1, 0.0]))).all()
    point, step = np.array([0.08, 0.0125]), 1e-6
    for i, unit in enumerate(np.eye(2)):
        ends = [np.asarray(values(point + s * step * unit)) for s in (1, -1)]
        difference = (ends[0] - ends[1]) / (2 * step)
        # truncation of (1e-6 / 0.0125)^2 and rounding of 1e-16 / 1e-6
        np.testing.assert_allclose(slopes(point)[:, i], difference, rtol=1e-6)


# ------------------------------------------------------------------------------- errors by phases


def outputs(angles):
    return PiOutputs(angles, None, None)


def test_angle_rmse_is_the_root_of_the_mean_of_both_squares():
    rng = np.random.default_rng(5)
    angles, truth = rng.normal(size=(40, 3, 2)), rng.normal(size=(40, 2))
    turn = np.arange(40) >= 25
    within = np.asarray(masked(truth, turn))
    error = np.degrees(angles - truth[:, None])
    by_hand = np.sqrt((error[turn] ** 2).sum(axis=-1).mean())
    assert float(rmse(outputs(angles), within[:, None])) == pytest.approx(by_hand, rel=1e-13)
    each = np.sqrt((error[turn] ** 2).sum(axis=-1).mean(axis=0))
    several = np.repeat(within[:, None], 3, axis=1)
    mean = jax.jit(Records(AngleRmse()), compiler_options=QUICK)(outputs(angles), several)
    assert float(mean) == pytest.approx(each.mean(), rel=1e-13)


def test_in_the_loop_it_is_the_same():
    rng = np.random.default_rng(6)
    angles, truth = rng.normal(size=(9, 2)), rng.normal(size=(9, 2))
    truth[4, 1] = np.nan
    one, total = AngleRmse(), AngleRmse().init()
    for row, true in zip(angles, truth, strict=True):
        total, kept = one.update(total, SimpleNamespace(angles=row), true)
        assert kept is None
    whole = float(rmse(outputs(angles), truth))
    assert float(one.value(total, None)) == pytest.approx(whole, rel=1e-14)


def test_angle_rmse_without_a_truth_or_an_error():
    zeros, holed = np.zeros((5, 2)), np.zeros((5, 2))
    holed[2] = np.nan
    assert np.isnan(rmse(outputs(zeros), np.nan * zeros))
    slope = jax.jit(jax.grad(lambda angles: AngleRmse()(outputs(angles), holed)))(zeros)
    np.testing.assert_array_equal(slope, 0.0)


def test_gains_may_be_plain_numbers():
    loop = ComplementaryLoop(0.05, 0.0125)
    np.testing.assert_allclose(loop.poles, [-0.025, -0.025], atol=1e-9)
    assert float(loop.damping) == pytest.approx(1.0)
    assert float(loop.natural_frequency) == pytest.approx(0.025)
    assert float(loop.bias_error(jnp.array(1.0))) == 0


@pytest.mark.parametrize("gains", [(-0.1, 0.1), (0.1, -0.1), (-0.1, -0.1)])
def test_a_loop_that_is_not_stable_has_no_damping_and_endless_variance(gains):
    loop = ComplementaryLoop(*(jnp.asarray(gain) for gain in gains))
    assert np.isnan(loop.damping)
    assert np.isnan(loop.natural_frequency)
    assert np.isinf(loop.variance(SensorNoise(rate=1.0, angle=1.0)))
