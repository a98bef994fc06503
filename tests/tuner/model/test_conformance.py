"""What every filter has to do, of the filters of documents: the checks of the battery."""

import jax.numpy as jnp
import numpy as np
import pytest

from tests.filters import test_battery as battery
from tests.filters.battery import Case, N
from tests.tuner.model.documents import OSCILLATOR, WHEELS, made

_RNG = np.random.default_rng(20260101)
_FORCE = jnp.asarray(_RNG.normal(size=N))
_OSCILLATOR, _WHEELS = made(OSCILLATOR), made(WHEELS)


def _wheels(point):
    q_speed, q_turn, sigma = jnp.exp(point)
    return _WHEELS.params(q_speed, q_turn, sigma)


CASES = [
    Case(
        "linear, shared noise, an input",
        _OSCILLATOR(0.2),
        lambda point: _OSCILLATOR.params(*jnp.exp(point)),
        np.log([3.0, 0.1, 0.5, 0.3]),
        _RNG.normal(size=(N, 2)),
        lambda z: _OSCILLATOR.inputs(_FORCE, jnp.asarray(z)[:, 0], jnp.asarray(z)[:, 1]),
    ),
    Case(
        "continuous and nonlinear, a measured angle, noise that a channel tells",
        _WHEELS(0.2),
        _wheels,
        np.log([0.3, 0.1, 0.8]),
        0.5 * _RNG.normal(size=(N, 3)),
        lambda z: _WHEELS.inputs(
            _FORCE, 0.3 * _FORCE, 1 + _FORCE**2, jnp.asarray(z)[:, :2], jnp.asarray(z)[:, 2]
        ),
    ),
]
CHECKS = [
    battery.test_words_and_sample_times_are_checked,
    battery.test_frozen_and_hashable,
    battery.test_equal_instances_share_one_compilation,
    battery.test_two_runs_are_equal_to_the_bit,
    battery.test_outputs_are_float64_with_time_first,
    battery.test_single_precision_stays_single,
    battery.test_a_constant_sample_time_may_come_with_every_sample,
    battery.test_typical_values_make_what_the_filter_takes,
    battery.test_facts_are_whole,
    battery.test_vmap_over_parameters_equals_a_loop,
    battery.test_missing_sample_leaves_the_past_alone_and_the_future_finite,
]


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__.removeprefix("test_"))
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_battery(case, check):
    check(case)


def test_it_is_the_same_without_compilation():
    """Of the linear one; the other takes seconds, and is held against a loop in NumPy."""
    battery.test_compiled_equals_uncompiled(CASES[0])


@pytest.mark.parametrize("record", ["whole", "punctured"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_its_gradients(case, record):
    battery.test_gradient_equals_central_differences(case, record)
