"""A loop in C goes on with constant gains where they have settled: exact, whatever is missing."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from filters import Gated, Joined, JoinedSample, LinearKalman, LinearModel, Sample, Transition
from objectives import Data, InnovationLikelihood, score_and_gradient
from tests.tuner.code.compiled import needed
from tuner.native import settled_text
from tuner.native.compiled import Native

N = 900
AT = np.array([0.3, -0.5, 0.2])
MOVE, PUSH = jnp.array([[1.0, 0.1], [0.0, 1.0]]), jnp.array([[0.005], [0.1]])


def tracker(z):
    """Position by two sensors: after some 200 samples its gains are constant."""
    q, r, other = jnp.exp(z)
    parts = Transition(MOVE, PUSH, jnp.reshape(q, (1, 1))), jnp.eye(2)[:1].repeat(2, axis=0)
    return LinearModel(*parts, jnp.stack([r, other]), jnp.eye(2), jnp.zeros(2))


def record(missing=(), count=N):
    draw = np.random.default_rng(7)
    z = np.cumsum(0.1 * draw.normal(size=(count, 1)), 0) + draw.normal(size=(count, 2))
    for rows in missing:
        z[rows] = np.nan
    return Data(Sample(z), np.zeros(count))


def compiled(folder, **given):
    needed("cc")
    filter, judged = LinearKalman(), InnovationLikelihood()
    return Native(filter, judged, tracker, 3, record(), folder, **given)


@pytest.fixture(scope="module")
def native(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("code"))


@pytest.fixture(scope="module")
def every_sample(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("code"), settle=False)


@partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})
def by_xla(data, z):
    return score_and_gradient(LinearKalman(), InnovationLikelihood(), tracker, z, data)


def scores(native, data, z=AT):
    rows = native.rows(data)
    value, gradient = native.value_and_gradient(z, rows, data)
    return np.array([native.value(z, rows, data), value, *gradient])


@pytest.mark.parametrize(
    "missing",
    [
        (),
        (slice(0, 1),),
        (slice(400, 401), slice(700, 703)),
        (slice(300, 340), slice(345, 350), slice(N - 1, N)),
        ((slice(300, 800), 1),),
        ((slice(0, N, 40), 0),),
        (slice(0, N, 9),),
        (slice(0, N),),
    ],
)
def test_equal_to_the_recursion_of_every_sample(missing, native):
    data = record(missing)
    assert native.settles
    value, gradient = by_xla(data, AT)
    found = scores(native, data)
    assert found[:2] == pytest.approx([float(value)] * 2, rel=1e-12, nan_ok=True)
    np.testing.assert_allclose(found[2:], gradient, rtol=1e-10, atol=1e-12)


def test_share_of_the_samples_with_constant_gains(native, every_sample):
    rows = native.rows(record())
    assert 0.5 < native.settled(AT, rows) < 0.95
    assert native.settled(AT, rows[:20]) == 0
    assert 0.1 < native.settled(AT, rows, (450,)) < native.settled(AT, rows) - 0.1
    assert native.settled(AT, native.rows(record((slice(0, N, 9),)))) == 0
    assert every_sample.settled(AT, rows) == 0


@pytest.mark.parametrize("count", [1, 15, 16, 17, 24, 400])
def test_records_of_any_length(count, native):
    data = record(count=count)
    value, gradient = by_xla(data, AT)
    found = scores(native, data)
    assert found[:2] == pytest.approx([float(value)] * 2, rel=1e-12)
    np.testing.assert_allclose(found[2:], gradient, rtol=1e-10, atol=1e-12)


@settings(max_examples=60, deadline=None)
@given(
    q=st.floats(-60, 20),
    r=st.tuples(st.floats(-10, 10), st.floats(-10, 10)),
    gaps=st.lists(st.tuples(st.integers(0, 2999), st.integers(1, 60)), max_size=4),
)
def test_filters_that_forget_fast_slowly_or_never(q, r, gaps, native, every_sample):
    data = record([slice(at, at + long) for at, long in gaps], count=3000)
    z = np.array([q, *r])
    found, wanted = scores(native, data, z), scores(every_sample, data, z)
    np.testing.assert_allclose(found[:2], wanted[:2], rtol=1e-12)
    most = np.abs(wanted[2:]).max()
    np.testing.assert_allclose(found[2:], wanted[2:], rtol=0, atol=1e-10 * most)


def test_the_gains_are_taken_as_constant(monkeypatch, tmp_path):
    """Were they so too early, the result would differ: the short way is taken."""
    monkeypatch.setattr(settled_text, "_SAME", "0.5")
    monkeypatch.setattr(settled_text, "_DRIFT", "1e9")
    data = record()
    value, _ = by_xla(data, AT)
    early = scores(compiled(tmp_path), data)
    assert 1e-9 < np.abs(early[:2] / float(value) - 1).min() < 1e-2


@pytest.mark.parametrize("missing", [(), (slice(300, 340),), (slice(0, N),)])
def test_many_points_settle_together(missing, native):
    data, points = record(missing), np.stack([AT, -AT, 2 * AT, [-20.0, 0.0, 0.0]])
    values, gradients = native.values_and_gradients(points, native.rows(data), data)
    for k, z in enumerate(points):
        _, value, *gradient = scores(native, data, z)
        assert values[k] == pytest.approx(value, rel=1e-12, nan_ok=True)
        np.testing.assert_allclose(gradients[k], gradient, rtol=1e-10, atol=1e-12)


def rough(outputs, truth):
    """An objective of all samples together, for which outputs are kept."""
    return jnp.mean(jnp.diff(outputs.x[:, 0]) ** 2) + jnp.log(outputs.P[-1, 0, 0])


@pytest.mark.parametrize("missing", [(), (slice(700, 720), slice(725, 726))])
def test_what_is_kept_of_each_sample(missing, tmp_path):
    needed("cc")
    data = record(missing)
    native = Native(LinearKalman(), rough, tracker, 3, data, tmp_path)
    rows = native.rows(data)
    assert native.settled(AT, rows) > 0.2
    value, gradient = score_and_gradient(LinearKalman(), rough, tracker, AT, data)
    found = scores(native, data)
    assert found[:2] == pytest.approx([float(value)] * 2, rel=1e-12)
    np.testing.assert_allclose(found[2:], gradient, rtol=1e-10, atol=1e-12)


def turning(z):
    """A state that turns by a quarter a sample, of which almost nothing is measured."""
    step = Transition(jnp.array([[0.0, 1.0], [-1.0, 0.0]]), jnp.eye(2), jnp.zeros((2, 2)))
    R = 1e30 * jnp.exp(z[:1])
    return LinearModel(step, jnp.eye(2)[:1], R, jnp.diag(jnp.array([1.0, 4.0])), jnp.ones(2))


def test_a_covariance_that_turns_in_circles_is_not_constant(tmp_path):
    needed("cc")
    data = Data(Sample(record().inputs.z[:, :1]), np.zeros(N))
    native = Native(LinearKalman(), InnovationLikelihood(), turning, 1, data, tmp_path)
    assert native.settles
    assert native.settled(np.zeros(1), native.rows(data)) == 0


def settles(filter, data, folder):
    return Native(filter, InnovationLikelihood(), tracker, 3, data, folder).settles


def test_a_covariance_that_follows_the_samples_never_settles(tmp_path):
    needed("cc")
    data = record()
    z = data.inputs.z
    assert not settles(Gated(LinearKalman(), (((0, 0),), ((0, 1),))), data, tmp_path)
    changing = jax.tree.map(lambda leaf: np.stack([leaf] * N), tracker(AT).transition)
    assert settles(LinearKalman(), data, tmp_path)
    assert not settles(LinearKalman(), Data(Sample(z, None, changing), data.truth), tmp_path)


def test_known_inputs_and_records_end_to_end(tmp_path):
    """Where a record begins, the gains have to settle anew."""
    needed("cc")
    z = record().inputs.z
    begins = np.zeros(N, bool)
    begins[[0, 300, 420]] = True
    push = np.sin(np.arange(N))[:, None]
    data = Data(JoinedSample(begins, Sample(z, push)), np.zeros(N))

    def pushed(z):
        model = tracker(z)
        return model._replace(transition=model.transition._replace(B=jnp.ones((2, 1)) * z[0]))

    filter, judged = Joined(LinearKalman()), InnovationLikelihood()
    native = Native(filter, judged, pushed, 3, data, tmp_path)
    assert native.settles
    assert native._loop.settled.usual.zero == (0,)
    value, gradient = score_and_gradient(filter, judged, pushed, AT, data)
    found = scores(native, data)
    assert found[:2] == pytest.approx([float(value)] * 2, rel=1e-12)
    np.testing.assert_allclose(found[2:], gradient, rtol=1e-10, atol=1e-12)
