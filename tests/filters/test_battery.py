"""What every filter has to do, whatever it estimates: see battery.py for the cases."""

import dataclasses
import inspect
from functools import cache, partial
from typing import Literal, get_origin, get_type_hints

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import filters
from filters import Timed, TimedSample, run
from filters.declared import assembled, channel_facts, output, parameter_facts
from tests.filters.battery import CASES, Case, N
from tests.filters.by_numpy import evaluated
from tests.oracles import central_difference

BUILDING_BLOCKS = {
    "Batched",
    "ConventionalLoop",
    "ExtendedKalman",
    "GainCovariance",
    "KalmanCovariance",
    "LinearKalman",
    "RiccatiCovariance",
    "SteadyGain",
    "StoredGains",
    "TableCovariance",
    "UnscentedKalman",
}
"""They take a model, or another filter, and say so in their docstrings: no parameters to name."""
MEASURING = [case for case in CASES if case.holes]
every_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
every_measuring_case = pytest.mark.parametrize("case", MEASURING, ids=lambda case: case.name)
traced = []


def noted(filter, params, inputs):
    """The filter's run; the tracing of it is noted."""
    traced.append(filter)
    return run(filter, params, inputs)


compiled = jax.jit(noted, static_argnums=0)


def built(case: Case, point):
    """Its parameters as NumPy's arrays, whose types are the same however they were made."""
    return jax.tree.map(np.asarray, case.build(point))


def run_case(case: Case, point=None, measured=None):
    point = case.point if point is None else point
    measured = case.measured if measured is None else measured
    return compiled(case.filter, built(case, point), case.inputs(measured))


def loss(outputs):
    """One number that depends on every output: a sum of squares, each with a weight of its own.

    With one weight for all of them the loss of unit quaternions would be a constant.
    """
    leaves = jax.tree.leaves(outputs)
    weights = [1 + np.cos(np.arange(leaf.size)).reshape(leaf.shape) for leaf in leaves]
    pairs = zip(weights, leaves, strict=True)
    return sum((weight * leaf**2).sum() / (i + 1) for i, (weight, leaf) in enumerate(pairs))


def bits(tree):
    return [np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(tree)]


def punctured(case: Case, k: int):
    measured = case.measured.copy()
    measured[k] = np.nan
    return measured


def test_every_filter_of_the_package_is_in_the_battery():
    public = [getattr(filters, name) for name in filters.__all__]
    written = {
        thing
        for thing in public
        if inspect.isclass(thing)
        and {"init", "step"} <= set(vars(thing))
        and thing not in (filters.Filter, filters.Settling)  # a protocol, and the filter inside
    }
    assert {type(case.filter) for case in CASES} == written


@every_case
def test_words_and_sample_times_are_checked(case):
    hints = get_type_hints(type(case.filter))
    name = type(case.filter).__name__
    wrong = [(field, "nonsense") for field, hint in hints.items() if get_origin(hint) is Literal]
    wrong += [("dt", dt) for dt in (0.0, -0.01, np.nan, np.inf) if "dt" in hints]
    for field, value in wrong:
        with pytest.raises(ValueError, match=f"^{name}: {field} is .*; give ") as raised:
            dataclasses.replace(case.filter, **{field: value})
        assert str(raised.value).count("\n") == 0


@every_case
def test_frozen_and_hashable(case):
    assert hash(case.filter) == hash(dataclasses.replace(case.filter))
    with pytest.raises(dataclasses.FrozenInstanceError):
        case.filter.dt = 1.0


@every_case
def test_equal_instances_share_one_compilation(case):
    run_case(case)
    before = len(traced)
    other = dataclasses.replace(case.filter)
    compiled(other, built(case, case.point), case.inputs(case.measured))
    assert len(traced) == before > 0


@every_case
def test_two_runs_are_equal_to_the_bit(case):
    assert bits(run_case(case)) == bits(run_case(case))


@every_case
def test_outputs_are_float64_with_time_first(case):
    """And flags, which no state holds, are bool."""
    state, outputs = run_case(case)
    assert {leaf.dtype for leaf in jax.tree.leaves(state)} == {jnp.dtype("float64")}
    kinds = {leaf.dtype for leaf in jax.tree.leaves(outputs)}
    assert {jnp.dtype("float64")} <= kinds <= {jnp.dtype("float64"), jnp.dtype("bool")}
    assert {leaf.shape[0] for leaf in jax.tree.leaves(outputs)} == {N}


def single(tree):
    """Floating numbers in single precision."""
    return jax.tree.map(
        lambda leaf: leaf.astype(jnp.float32) if jnp.issubdtype(leaf.dtype, jnp.floating) else leaf,
        jax.tree.map(jnp.asarray, tree),
    )


@every_case
def test_single_precision_stays_single(case):
    """Of state and outputs, so that the filter that is checked is the one on the target."""

    def whole(params, inputs):
        return run(case.filter, params, inputs)

    given = single((case.build(case.point), case.inputs(case.measured)))
    found = jax.tree.leaves(jax.eval_shape(whole, *given))
    assert {leaf.dtype for leaf in found} - {jnp.dtype("bool")} == {jnp.dtype("float32")}


@every_case
def test_a_constant_sample_time_may_come_with_every_sample(case):
    if "dt" not in case.filter.__dataclass_fields__:
        with pytest.raises(ValueError, match="no sample time dt"):
            Timed(case.filter)
        return
    # Its own dt is not used.
    timed = Timed(dataclasses.replace(case.filter, dt=7.0))
    times = TimedSample(jnp.full(N, case.filter.dt), case.inputs(case.measured))
    _, found = evaluated(lambda p, u: run(timed, p, u), case.build(case.point), times)
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(run_case(case)[1]), strict=True):
        # Products of dt are rounded at another place: a few units in the last place of each step.
        np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-12)


@every_case
def test_typical_values_make_what_the_filter_takes(case):
    """And by the names that are declared its outputs are found."""
    name = type(case.filter).__name__
    if name in BUILDING_BLOCKS:
        with pytest.raises(ValueError, match=f"^{name} declares no params; give the class"):
            parameter_facts(case.filter)
        return
    facts = parameter_facts(case.filter)
    params = assembled(case.filter, {name: fact.typical for name, fact in facts.items()})
    # Of the case's own shapes: some filters take several signals.
    own = built(case, case.point)
    params = jax.tree.map(lambda typical, leaf: np.full(leaf.shape, typical), params, own)
    inputs = case.inputs(case.measured)
    state, outputs = compiled(case.filter, params, inputs)
    assert jax.tree.structure(state) == jax.tree.structure(run_case(case)[0])
    for part in ("inputs", "states"):
        assert channel_facts(case.filter, part)
    for name in channel_facts(case.filter, "outputs"):
        found = output(case.filter, outputs, name)
        assert found is None or np.isfinite(found).all(), name


@every_case
def test_facts_are_whole(case):
    """A typical value lies within its range, and what a search turns says what it does."""
    if type(case.filter).__name__ in BUILDING_BLOCKS:
        return
    for name, fact in parameter_facts(case.filter).items():
        assert fact.meaning, name
        assert (fact.low is None) == (fact.high is None), name
        if fact.low is not None:
            assert fact.low < fact.typical < fact.high, name
            assert fact.smaller, name
            assert fact.larger, name


@every_case
def test_vmap_over_parameters_equals_a_loop(case):
    points = case.point + np.array([[0.0], [0.3], [-0.5]])
    inputs = case.inputs(case.measured)
    lanes = evaluated(jax.vmap(lambda p: run(case.filter, case.build(p), inputs)[1]), points)
    for i, point in enumerate(points):
        alone = run_case(case, point)[1]
        for lane, single in zip(jax.tree.leaves(lanes), jax.tree.leaves(alone), strict=True):
            # The lanes' sums may be fused in another order: a few units in the last place, and
            # N = 24 samples to add them up.
            np.testing.assert_allclose(lane[i], single, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(
    "case",
    # Those that take longest without compilation are held against loops in NumPy elsewhere.
    [
        c
        for c in CASES
        if not any(word in c.name for word in ("signals", "Euler", "room", "mixing"))
    ],
    ids=lambda case: case.name,
)
def test_compiled_equals_uncompiled(case):
    """The first samples of the record, which the later ones do not change."""
    first = 2
    inputs = jax.tree.map(lambda leaf: np.asarray(leaf)[:first], case.inputs(case.measured))
    with jax.disable_jit():
        _, slow = run(case.filter, case.build(case.point), inputs)
    fast = run_case(case)[1]
    for one, other in zip(jax.tree.leaves(fast), jax.tree.leaves(slow), strict=True):
        np.testing.assert_allclose(one[:first], other, rtol=1e-13, atol=1e-14)  # fused sums only


@cache
def gradients(case: Case):
    """The value, its gradient backwards and its slope along (1, 1, ...) forwards, traced once.

    To compile both loops would take three times as long.
    """

    def value(point, inputs):
        return loss(run(case.filter, case.build(point), inputs)[1])

    def both_ways(point, inputs):
        ahead = jax.jvp(lambda p: value(p, inputs), (point,), (jnp.ones_like(point),))
        return *jax.value_and_grad(value)(point, inputs), ahead[1]

    return partial(evaluated, both_ways)


@pytest.mark.parametrize(
    ("case", "record"),
    [(case, "whole") for case in CASES] + [(case, "punctured") for case in MEASURING],
    ids=lambda value: value if isinstance(value, str) else value.name,
)
def test_gradient_equals_central_differences(case, record):
    inputs = case.inputs(punctured(case, 7) if record == "punctured" else case.measured)

    def by_numpy(point):  # JAX would compile every sum
        return loss(jax.tree.map(np.asarray, compiled(case.filter, built(case, point), inputs)[1]))

    difference = central_difference(by_numpy, case.point, 1e-5)
    value, backwards, forwards = gradients(case)(case.point, inputs)
    assert np.isfinite(value)
    # A step h = 1e-5 leaves h^2 = 1e-10 of truncation and eps/h = 2e-11 of rounding, each times
    # a factor of order ten.
    scale = np.abs(difference).max()
    np.testing.assert_allclose(backwards, difference, rtol=1e-7, atol=1e-7 * scale)
    # Forwards and backwards are the same sums in another order.
    np.testing.assert_allclose(forwards, backwards.sum(), rtol=0, atol=1e-11 * scale)


@every_measuring_case
def test_missing_sample_leaves_the_past_alone_and_the_future_finite(case):
    whole, holed = (run_case(case, measured=z)[1] for z in (case.measured, punctured(case, 7)))
    for one, other in zip(jax.tree.leaves(whole), jax.tree.leaves(holed), strict=True):
        assert np.asarray(one[:7]).tobytes() == np.asarray(other[:7]).tobytes()
        assert np.isfinite(other).all()
    # Not the same as a sample of zero, and not without an effect on what follows.
    zeroed = case.measured.copy()
    zeroed[7] = 0.0
    outputs = [jax.tree.leaves(o)[0] for o in (whole, holed, run_case(case, measured=zeroed)[1])]
    for i, j in ((0, 1), (1, 2)):
        assert np.abs(outputs[i][7:] - outputs[j][7:]).max() > 1e-6


@pytest.mark.parametrize(
    "case", [c for c in MEASURING if c.measured.ndim == 1], ids=lambda case: case.name
)
def test_one_missing_sample_is_one_step_of_prediction(case):
    """Whatever is measured at a missing sample, the estimate there is the prediction.

    The prediction is found without the filter's formulas: the filter's answer is a line in the
    measurement, prediction + gain * (z - prediction), and crosses z = answer at the prediction.
    """

    def answer(z):
        measured = case.measured.copy()
        measured[7] = z
        estimate = jax.tree.leaves(run_case(case, measured=measured)[1])[0]
        return float(np.asarray(estimate).ravel()[7])

    at_zero, at_one = answer(0.0), answer(1.0)
    gain = at_one - at_zero
    # prediction (1 - gain) = answer(0); the gain is of order 0.3, so a few digits go in 1 - gain
    assert answer(np.nan) == pytest.approx(at_zero / (1 - gain), rel=1e-12)
