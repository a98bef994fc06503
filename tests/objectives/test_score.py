"""Scores and their gradients: one number whichever way the objective is written."""

from dataclasses import replace
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import AccelerometerFilter, GyroscopeFilter, KownackiNoise, run
from objectives import (
    Crossing,
    Data,
    Folded,
    Reading,
    StepResponse,
    Welch,
    is_fold,
    kept_bytes,
    score,
    score_and_gradient,
    scores_and_gradients,
)
from tests.oracles import central_difference
from tests.published import step_signal

N, DT = 1000, 1e-3
SIGNALS = np.stack([step_signal(N, 300), 0.01 * np.random.default_rng(7).normal(size=N)], axis=1)
GYRO, ACC = GyroscopeFilter(DT, (2,)), AccelerometerFilter(DT, (2,))
POINT = np.log([1e-4, 1.0])

COSTS = [
    StepResponse(DT, Welch.matlab(N), reading, crossing, weight=0.3)
    for reading, crossing in [
        (Reading.R1, Crossing.HINGE),
        (Reading.R2, Crossing.FIRST),
        (Reading.R6, Crossing.HINGE),
    ]
]
every_cost = pytest.mark.parametrize(
    "cost", COSTS, ids=lambda c: f"{c.reading.name} {c.crossing.name}"
)
scored = jax.jit(score, static_argnums=(0, 1))
derived = jax.jit(score_and_gradient, static_argnums=(0, 1, 2))


def build(z):
    return KownackiNoise.of(R=jnp.exp(z[0]), Q=jnp.exp(z[1]))


def data(cost, signals=SIGNALS):
    return Data(jnp.asarray(signals), cost.truth(SIGNALS[:, 0]))


@cache
def plainly(cost):
    """The same cost as a plain function of all outputs and the truth."""

    def measure(outputs, truth):
        whole, noise = outputs.sum(axis=1), outputs[:, 1]
        lag = truth.step - whole
        if cost.crossing is Crossing.HINGE:
            square = truth.lag_weight * jnp.maximum(lag, 0) ** 2
        else:
            arrived = (lag <= 0) & (truth.step > 0)
            before = jnp.cumsum(arrived) == 0
            at = arrived & (jnp.cumsum(arrived) == 1)
            square = (
                jnp.where(before, truth.lag_weight, jnp.where(at, truth.last_weight, 0)) * lag**2
            )
        density = cost.welch.psd(whole if cost.reading is Reading.R1 else noise, DT)
        if cost.reading is Reading.R6:
            density = jnp.sqrt(density)
        return square.sum() + cost.weight * density.sum() / (cost.welch.nfft * DT)

    return measure


@every_cost
def test_a_fold_and_a_plain_function_score_the_same(cost):
    fold, plain = (scored(GYRO, form, build(POINT), data(cost)) for form in (cost, plainly(cost)))
    assert is_fold(cost)
    assert not is_fold(plainly(cost))
    assert float(fold) == pytest.approx(float(plain), rel=1e-12)  # sums of 1000 in another order


@every_cost
def test_gradient_is_that_of_jax_backwards(cost):
    """Loop forwards and spectrum backwards, against all of it backwards."""
    value, gradient = derived(GYRO, cost, build, POINT, data(cost))
    assert float(value) == pytest.approx(
        float(scored(GYRO, cost, build(POINT), data(cost))), rel=1e-13
    )
    backwards = jax.jit(jax.grad(lambda z: score(GYRO, cost, build(z), data(cost))))(POINT)
    # Sums over 1000 samples in another order; some terms cancel a thousandfold.
    np.testing.assert_allclose(gradient, backwards, rtol=1e-10)


def test_gradient_of_a_plain_function_is_that_of_the_fold():
    cost = COSTS[2]
    fold, plain = (derived(GYRO, form, build, POINT, data(cost)) for form in (cost, plainly(cost)))
    assert float(plain[0]) == pytest.approx(float(fold[0]), rel=1e-12)
    np.testing.assert_allclose(plain[1], fold[1], rtol=1e-10)  # as above


@every_cost
def test_gradient_equals_central_differences(cost):
    _, gradient = derived(GYRO, cost, build, POINT, data(cost))

    def value(z):
        return float(scored(GYRO, cost, build(z), data(cost)))

    difference = central_difference(value, POINT, 1e-3)
    # Step 1e-3 in the logarithm leaves h^2 = 1e-6 times a third derivative of the same order.
    np.testing.assert_allclose(gradient, difference, rtol=3e-6)


def test_gradient_of_a_filter_with_holes_in_its_record_is_finite():
    holed = SIGNALS.copy()
    holed[100:120, 1] = np.nan
    for cost in COSTS:
        value, gradient = derived(GYRO, cost, build, POINT, data(cost, holed))
        assert np.isfinite(value)
        assert np.isfinite(gradient).all()


def test_gradient_for_a_record_of_zeros_is_that_of_the_first_integral():
    """The root of the spectrum has no slope at 0; 0 is the one that belongs to a silent record."""
    silent = SIGNALS * np.array([1.0, 0.0])
    amplitude = COSTS[2]
    value, gradient = derived(GYRO, amplitude, build, POINT, data(amplitude, silent))
    unweighted = replace(COSTS[0], weight=0.0)
    expected = derived(GYRO, unweighted, build, POINT, data(unweighted, silent))
    assert float(value) == pytest.approx(float(expected[0]), rel=1e-13)
    np.testing.assert_allclose(gradient, expected[1], rtol=1e-12)


@pytest.mark.parametrize("cost", COSTS[1:], ids=["R2", "R6"])
def test_many_points_at_once_are_each_alone(cost):
    points = POINT + np.array([[0.0, 0.0], [1.0, -1.0], [-2.0, 0.5]])
    together = jax.jit(scores_and_gradients, static_argnums=(0, 1, 2))
    values, gradients = together(GYRO, cost, build, jnp.asarray(points), data(cost))
    for point, value, gradient in zip(points, values, gradients, strict=True):
        alone = derived(GYRO, cost, build, point, data(cost))
        assert float(value) == pytest.approx(float(alone[0]), rel=1e-12)  # another fusion
        np.testing.assert_allclose(gradient, alone[1], rtol=1e-10)


@pytest.mark.parametrize(("filter", "cost"), [(GYRO, cost) for cost in COSTS] + [(ACC, COSTS[2])])
def test_scaling_all_covariances_leaves_the_cost(filter, cost):
    for c in (1e-6, 7.3, 1e6):
        one = scored(filter, cost, KownackiNoise(1e-4, 1.0, jnp.ones((2, 2))), data(cost))
        other = scored(filter, cost, KownackiNoise(c * 1e-4, c, c * jnp.ones((2, 2))), data(cost))
        assert float(other) == pytest.approx(float(one), rel=1e-12)  # rounding of c * R alone


@every_cost
def test_only_the_amplitude_keeps_anything(cost):
    expected = 8 * N if cost.reading is Reading.R6 else 0  # one float64 a sample
    assert kept_bytes(GYRO, cost, build(POINT), data(cost)) == expected
    assert kept_bytes(GYRO, plainly(cost), build(POINT), data(cost)) == 2 * 8 * N


def test_a_folded_filter_is_the_filter():
    cost = COSTS[2]
    (state, _), kept = jax.jit(run, static_argnums=0)(Folded(GYRO, cost), build(POINT), data(cost))
    expected, outputs = jax.jit(run, static_argnums=0)(GYRO, build(POINT), jnp.asarray(SIGNALS))
    # the same operations, fused with others
    np.testing.assert_allclose(kept, outputs[:, 1], rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.array(state.omega), np.array(expected.omega), rtol=1e-12)


def test_equal_folds_share_one_compilation():
    traced = []

    def noted(folded, params, inputs):
        traced.append(folded)
        return run(folded, params, inputs)

    once = jax.jit(noted, static_argnums=0)
    for _ in range(2):
        cost = StepResponse(DT, Welch(222, 111, 256), Reading.R6)
        once.lower(Folded(GyroscopeFilter(DT, (2,)), cost), build(POINT), data(cost))
    assert len(traced) == 1
