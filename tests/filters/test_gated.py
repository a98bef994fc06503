"""The gate against textbook loops, on every filter with innovations, and where it might lock up."""

from functools import cache, partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import (
    AngleSample,
    AttitudeKalman,
    BoundedMotionKalman,
    Complementary,
    ComplementaryGain,
    ConstantVelocity,
    ConstantVelocityNoise,
    Gated,
    Lanes,
    LevelSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    LocalLevelNoise,
    PositionSample,
    Sample,
    Timed,
    TimedSample,
    Transition,
    Vertical,
    VerticalNoise,
    VerticalSample,
    measured_entries,
    run,
)
from tests.filters.battery import CASES
from tests.filters.by_numpy import evaluated

quickly = partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})
HUGE = 1e6


def has_innovations(case):
    outputs = getattr(case.filter, "outputs", None)
    return {"innovation", "variance"} <= set(getattr(outputs, "_fields", ()))


SIGNALS = "linear, diagonal R, control, three signals"
SLOW = "inertial navigation, all aiding"  # twelve innovations: half a minute to compile
JUDGED = [case for case in CASES if has_innovations(case) and case.name not in (SIGNALS, SLOW)]
every_judged_case = pytest.mark.parametrize("case", JUDGED, ids=lambda case: case.name)


@cache
def found(case):
    params, inputs = case.build(jnp.asarray(case.point)), case.inputs(case.measured)
    return params, inputs, measured_entries(case.filter, params, inputs)


@every_judged_case
def test_a_huge_gate_changes_nothing(case):
    params, inputs, parts = found(case)
    if isinstance(case.filter, BoundedMotionKalman):
        assert not any(parts)  # its pseudo-measurements come from no sensor
        return
    assert all(parts)
    gated = Gated(case.filter, parts, HUGE)
    plain, outputs = (
        evaluated(lambda p, u, f=f: run(f, p, u)[1], params, inputs) for f in (case.filter, gated)
    )
    for name in plain._fields:
        np.testing.assert_allclose(
            getattr(outputs, name), getattr(plain, name), rtol=1e-12, atol=1e-12, err_msg=name
        )
    assert not outputs.rejected.any()
    assert outputs.predicted.any()


def test_several_signals_of_one_filter_are_refused():
    case = next(each for each in CASES if each.name == SIGNALS)
    params, inputs = case.build(jnp.asarray(case.point)), case.inputs(case.measured)
    with pytest.raises(ValueError, match="several signals pass through one LinearKalman"):
        measured_entries(case.filter, params, inputs)


def test_known_inputs_are_no_measurements():
    record = VerticalSample(acc=jnp.zeros(9), baro=jnp.ones(9))
    assert measured_entries(Vertical(0.1), VerticalNoise(0.01, 1e-4, 0.1), record) == (((1, 0),),)
    case = next(c for c in CASES if isinstance(c.filter, AttitudeKalman))
    _, inputs, parts = found(case)
    leaves = [id(leaf) for leaf in jax.tree.leaves(inputs)]
    assert {leaf for part in parts for leaf, _ in part} == {leaves.index(id(inputs.acc))}


def test_in_navigation_numbers_of_one_direction_go_together():
    case = next(c for c in CASES if c.name == SLOW)
    sizes = [len(part) for part in found(case)[2]]
    assert sizes == [1, 1, 1, 0, 0, 0, 1, 1, 3, 1, 1, 1]  # GPS velocity has no channel here


def level_loop(z, q, R, gate, patience):
    """Level after each sample, and whether it was rejected, as a person would write it."""
    level, p, row, found = z[0], R, 0, [(z[0], 0)]
    for zk in z[1:]:
        p = p + q
        s, y = p + R, zk - level
        beyond = y**2 > gate**2 * s
        rejected = beyond and row < patience
        row = row + 1 if beyond else 0
        if not rejected:
            level, p = level + p / s * y, p * R / s
        found.append((level, int(rejected)))
    return np.array(found).T


def level_record(seed=1, n=200):
    draw = np.random.default_rng(seed)
    z = np.cumsum(0.1 * draw.standard_normal(n)) + draw.standard_normal(n)
    z[draw.random(n) < 0.1] += 30.0
    z[0] = 0.0
    return z


def level_run(z, gate=4.0, patience=10, q=0.01, R=1.0):
    noise, record = LocalLevelNoise(jnp.array(q), jnp.array(R)), LevelSample(jnp.asarray(z))
    filter = LocalLevel(1.0)
    return run(
        Gated(filter, measured_entries(filter, noise, record), gate, patience), noise, record
    )[1]


@pytest.mark.parametrize("patience", [1, 2, 10])
def test_a_level_equals_the_loop(patience):
    z = level_record()
    outputs = level_run(z, patience=patience)
    level, rejected = level_loop(z, 0.01, 1.0, 4.0, patience)
    assert rejected.sum() > 5
    np.testing.assert_allclose(outputs.level, level, rtol=1e-12)
    np.testing.assert_array_equal(outputs.rejected[:, 0], rejected)


def test_what_is_refused_is_as_if_missing():
    z = level_record()
    outputs = level_run(z)
    gone = outputs.rejected[:, 0] > 0
    without = run(
        LocalLevel(1.0),
        LocalLevelNoise(jnp.array(0.01), jnp.array(1.0)),
        LevelSample(jnp.where(gone, jnp.nan, z)),
    )[1]
    np.testing.assert_array_equal(outputs.level, without.level)
    np.testing.assert_array_equal(outputs.innovation, without.innovation)
    np.testing.assert_array_equal(outputs.variance, without.variance)
    assert (outputs.offered[gone] ** 2 > 16 * outputs.predicted[gone]).all()


def test_a_jump_locks_it_for_its_patience_alone():
    z = np.zeros(200)
    z[100:] = 1000.0
    outputs = level_run(z, patience=10)
    assert outputs.rejected[100:110].all()
    assert not outputs.rejected[110:].any()
    assert abs(float(outputs.level[199]) - 1000) < 1


def test_a_wrong_first_sample_is_left_behind():
    z = 0.1 * np.random.default_rng(2).standard_normal(300)
    z[0] = 500.0
    outputs = level_run(z, q=0.01, R=0.01)
    assert outputs.rejected.sum() == 10
    assert abs(float(outputs.level[-1])) < 0.2


def test_without_patience_left_an_outlier_does_not_open_the_gate_for_the_next():
    z = np.zeros(50)
    z[[20, 22, 24]] = 100.0  # between them right numbers, which shut the gate again
    assert level_run(z, patience=1, q=1e-4).rejected.sum() == 3


def pair(R):
    """A level that two sensors see."""
    one = jnp.ones((1, 1))
    return LinearModel(Transition(one, one, 0.01 * one), jnp.ones((2, 1)), R, one, jnp.zeros(1))


def pair_loop(z, gate):
    x, p, found = 0.0, 1.0, []
    for sample in z:
        p, rejected = p + 0.01, [0, 0]
        for i, zk in enumerate(sample):
            s, y = p + 0.25, zk - x
            if y**2 > gate**2 * s:
                rejected[i] = 1
                continue
            x, p = x + p / s * y, p * 0.25 / s
        found.append((x, *rejected))
    return np.array(found).T


@pytest.mark.parametrize("full", [False, True])
def test_two_sensors_of_one_state_are_judged_one_after_another(full):
    """A wrong first sensor has to be out before the second one is judged."""
    z = 0.5 * np.random.default_rng(3).standard_normal((60, 2))
    z[20, 0] = z[30, 1] = 40.0
    z[40] = 40.0, -40.0
    R = 0.25 * (jnp.eye(2) if full else jnp.ones(2))
    record = Sample(jnp.asarray(z))
    filter = LinearKalman()
    outputs = run(Gated(filter, measured_entries(filter, pair(R), record), 4.0), pair(R), record)[1]
    x, first, second = pair_loop(z, 4.0)
    assert (first.sum(), second.sum()) == (2, 2)
    np.testing.assert_array_equal(outputs.rejected.T, [first, second])
    np.testing.assert_allclose(outputs.x[:, 0], x, rtol=1e-12)
    np.testing.assert_allclose(outputs.offered[20, 0], 40.0, atol=1.0)


def test_axes_are_refused_each_by_itself_at_varying_times_and_side_by_side():
    draw = np.random.default_rng(4)
    x, y = 0.1 * draw.standard_normal((2, 80, 2))
    x[40, 0] = y[50, 0] = y[50, 1] = x[50, 1] = 9.0
    dt = jnp.asarray(draw.uniform(0.5, 1.5, 80))
    noise = ConstantVelocityNoise(jnp.array(1e-3), jnp.array(0.01))
    one = Timed(ConstantVelocity(1.0, "xy"))

    def record(lane):
        return TimedSample(dt, PositionSample(jnp.asarray(x[:, lane]), jnp.asarray(y[:, lane])))

    gated = Gated(one, measured_entries(one, noise, record(0)))
    both = TimedSample(jnp.stack([dt, dt], axis=1), PositionSample(jnp.asarray(x), jnp.asarray(y)))
    outputs = run(Lanes(gated, 2), noise, both)[1]
    where = np.argwhere(np.asarray(outputs.rejected) > 0).tolist()
    assert where == [[40, 0, 0], [50, 0, 1], [50, 1, 0], [50, 1, 1]]
    alone = run(gated, noise, record(1))[1]
    np.testing.assert_allclose(outputs.position[:, 1], alone.position, rtol=1e-12)


def test_the_gradient_passes_a_gate_both_ways():
    z = level_record(n=60)

    def loss(logs):
        q, R = jnp.exp(logs)
        noise, record = LocalLevelNoise(q, R), LevelSample(jnp.asarray(z))
        out = run(Gated(LocalLevel(1.0), (((0, 0),),)), noise, record)[1]
        seen = out.variance > 0
        s = jnp.where(seen, out.variance, 1.0)
        return jnp.where(seen, out.innovation**2 / s + jnp.log(s), 0.0).sum()

    at, h = jnp.log(jnp.array([0.01, 1.0])), 1e-6
    quick = quickly(loss)
    slope = [(quick(at + h * e) - quick(at - h * e)) / (2 * h) for e in np.eye(2)]
    np.testing.assert_allclose(quickly(jax.grad(loss))(at), slope, rtol=1e-6)
    np.testing.assert_allclose(quickly(jax.jacfwd(loss))(at), slope, rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gate": 0.5}, "more than a third of what is right"),
        ({"gate": float("nan")}, "more than a third"),
        ({"patience": 0}, "give 1 or more"),
        ({"parts": ((),)}, "nothing to refuse"),
    ],
)
def test_a_gate_that_is_none_is_refused(change, words):
    with pytest.raises(ValueError, match=words):
        Gated(LocalLevel(1.0), **{"parts": (((0, 0),),)} | change)


def test_samples_of_another_form_are_refused():
    gated = Gated(LocalLevel(1.0), (((3, 0),),))
    with pytest.raises(ValueError, match="find them again"):
        run(gated, LocalLevelNoise(jnp.ones(()), jnp.ones(())), LevelSample(jnp.zeros(3)))


def test_a_filter_without_innovations_has_nothing_to_refuse():
    gains = ComplementaryGain(jnp.array(1.0), jnp.array(0.0))
    with pytest.raises(ValueError, match="Complementary outputs no innovation and no variance"):
        measured_entries(Complementary(0.1), gains, AngleSample(jnp.zeros(3), jnp.zeros(3)))
