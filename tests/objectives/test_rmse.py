"""Errors of named outputs against loops in plain NumPy."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filters import Batched, Channel, Param, run, shared
from objectives import AttitudeRmse, ChannelRmse, Data, score
from tests.oracles import central_difference
from tests.strategies import seeds

N, K = 12, 3


class Motion(NamedTuple):
    place: Annotated[Any, Channel("m", "where it is", ("x", "y", "z"))]
    turn: Annotated[Any, Channel("rad", "its heading", kind="angle")]
    level: Annotated[Any, Channel("m", "its height")]
    att: Annotated[Any, Channel("", "its attitude", ("w", "x", "y", "z"), "attitude")]
    variance: Annotated[Any, Channel("m^2", "of the height", kind="detail")]


@dataclass(frozen=True)
class Gain:
    """Multiplies its input: a filter whose outputs are known without a filter."""

    params, inputs, outputs = (
        {"gain": Param("", "factor", 1.0)},
        {"u": Channel("m", "anything")},
        {"level": Channel("m", "the same")},
    )

    def init(self, params):
        return jnp.zeros(())

    def step(self, params, state, inputs):
        return state, params * inputs


@dataclass(frozen=True)
class Named(Gain):
    outputs = Motion

    def step(self, params, state, inputs):
        x = params * inputs
        return state, Motion(x * jnp.ones(3), x, x, jnp.array([1.0, 0.0, 0.0, 0.0]), x)


def by_hand(estimate, truth, angle):
    """One loop over all numbers, and the error within half a turn by the arc tangent."""
    total, count = 0.0, 0
    for a, b in zip(np.ravel(estimate), np.ravel(truth), strict=True):
        if math.isnan(b):
            continue
        d = math.atan2(math.sin(a - b), math.cos(a - b)) if angle else a - b
        total, count = total + d * d, count + 1
    return math.sqrt(total / count) if count else math.nan


def record(rng, shape, missing=0.3):
    truth = rng.normal(scale=4.0, size=shape)
    truth[rng.uniform(size=shape) < missing] = np.nan
    return rng.normal(scale=4.0, size=shape), truth


@given(rng=seeds(), kind=st.sampled_from(["number", "angle"]), several=st.booleans())
def test_a_single_number_equals_a_loop_over_one_long_record(rng, kind, several):
    estimate, truth = record(rng, (N, K) if several else (N,))
    expected = by_hand(estimate, truth, kind == "angle")
    # sums of some tens of squares of order 10; an arc tangent of sines rounds at 1e-15
    found = float(ChannelRmse("", kind)(estimate, truth))
    assert found == pytest.approx(expected, rel=1e-12, nan_ok=True)


@given(rng=seeds())
def test_the_squares_of_a_vector_are_added(rng):
    estimate, truth = record(rng, (N, K, 3), missing=0.0)
    truth[rng.uniform(size=(N, K)) < 0.3] = np.nan
    seen = ~np.isnan(truth).any(axis=2)
    lengths = [np.linalg.norm(estimate[n, k] - truth[n, k]) for n, k in np.argwhere(seen)]
    expected = math.sqrt(sum(d * d for d in lengths) / len(lengths))
    found = float(ChannelRmse("", parts=3)(estimate, truth))
    assert found == pytest.approx(expected, rel=1e-12)


def test_a_part_of_a_vector_may_be_missing_alone():
    truth = np.array([[3.0, np.nan], [5.0, np.nan]])
    # the mean square of the numbers that count, for each of two parts
    assert float(ChannelRmse("", parts=2)(np.zeros((2, 2)), truth)) == pytest.approx(
        math.sqrt(2 * (9.0 + 25.0) / 2), rel=1e-15
    )


@pytest.mark.parametrize(("turns", "left"), [(1, 0.1), (-3, 0.1), (0.5, math.pi - 0.1)])
def test_whole_turns_are_no_error(turns, left):
    found = ChannelRmse("", "angle")(jnp.array([0.1 + 2 * math.pi * turns]), jnp.zeros(1))
    assert float(found) == pytest.approx(left, abs=1e-14)
    assert float(ChannelRmse("")(jnp.array([6.0]), jnp.zeros(1))) == 6.0


@pytest.mark.parametrize("kind", ["number", "angle"])
def test_the_gradient_is_that_of_a_loop_and_finite_beside_missing_truths(kind):
    estimate, truth = record(np.random.default_rng(1), (N,))
    error = ChannelRmse("", kind)
    found = np.asarray(jax.grad(error)(jnp.asarray(estimate), truth))
    rough = central_difference(lambda x: by_hand(x, truth, kind == "angle"), estimate, 1e-5)
    np.testing.assert_array_equal(found[np.isnan(truth)], 0.0)
    # h^2 = 1e-10 of truncation and eps/h = 2e-11 of rounding
    np.testing.assert_allclose(found, rough, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("kind", ["number", "angle"])
def test_without_an_error_the_gradient_is_zero(kind):
    truth = jnp.arange(4.0).at[1].set(jnp.nan)
    value, slope = jax.value_and_grad(ChannelRmse("", kind))(jnp.arange(4.0), truth)
    assert float(value) == 0.0
    np.testing.assert_array_equal(slope, 0.0)


def test_nothing_that_counts_is_no_error_of_zero():
    assert np.isnan(ChannelRmse("")(jnp.zeros(3), jnp.full(3, jnp.nan)))
    # and an estimate that is no number is one that the value has to show
    assert np.isnan(ChannelRmse("")(jnp.array([0.0, jnp.nan]), jnp.zeros(2)))


@pytest.mark.parametrize("name", ["place", "turn", "level"])
def test_in_the_loop_it_is_the_same_and_keeps_nothing(name):
    u = jnp.asarray(np.random.default_rng(3).normal(scale=3.0, size=N))
    outputs = run(Named(), jnp.array(1.5), u)[1]
    truth = jnp.roll(getattr(outputs, name), 1, axis=0).at[2].set(jnp.nan)
    error = ChannelRmse.of(Named, name)
    assert error.update(error.init(), jax.tree.map(lambda x: x[0], outputs), truth[0])[1] is None
    found = score(Named(), error, jnp.array(1.5), Data(u, truth))
    expected = by_hand(getattr(outputs, name), truth, name == "turn")
    assert float(found) == pytest.approx(math.sqrt(error.parts) * expected, rel=1e-12)


def test_records_side_by_side_are_one_long_record():
    u = jnp.asarray(np.random.default_rng(4).normal(size=(N, K)))
    truth = (2 * u).at[N // 2 :, 1].set(jnp.nan)  # the second is shorter
    error = ChannelRmse.of(Gain, "level")
    found = score(Batched(Gain()), error, shared(jnp.array(1.0), K), Data(u, truth))
    assert float(found) == pytest.approx(by_hand(u, truth, angle=False), rel=1e-13)


def test_facts_say_how_an_output_is_scored():
    assert ChannelRmse.of(Gain(), "level") == ChannelRmse("", "number", 1)
    assert ChannelRmse.of(Named, "place") == ChannelRmse("place", "number", 3)
    assert ChannelRmse.of(Named, "turn") == ChannelRmse("turn", "angle", 1)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ChannelRmse.of(Named, "att"), "'att' is of kind 'attitude'; .* AttitudeRmse"),
        (lambda: ChannelRmse.of(Named, "variance"), "'variance' is of kind 'detail'"),
        (lambda: ChannelRmse.of(Named, "plase"), "'plase' is not among .*: place, turn, level"),
        (lambda: ChannelRmse("", "turn"), "'' is of kind 'turn'"),
        (lambda: ChannelRmse("", parts=0), "'' has 0 parts; give 1 or more"),
        (lambda: ChannelRmse("x")(jnp.zeros(2), jnp.zeros(2)), "has no output 'x'; give"),
        (lambda: ChannelRmse("")(jnp.zeros((2, 3)), jnp.zeros(2)), r"shape \(2, 3\) .* \(2,\)"),
    ],
)
def test_what_cannot_be_scored_is_said_in_one_sentence(make, words):
    with pytest.raises(ValueError, match=words) as told:
        make()
    assert len(str(told.value).splitlines()) == 1


def test_an_attitude_is_scored_inside_a_tuple():
    u, level = jnp.ones(N), jnp.tile(jnp.array([1.0, 0.0, 0.0, 0.0]), (N, 1))
    assert float(score(Named(), AttitudeRmse(), jnp.array(1.0), Data(u, level))) == 0.0
