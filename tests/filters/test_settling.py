"""Once its gains are constant a filter takes many samples at once, with the same result."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from filters import (
    ConstantVelocity,
    ConstantVelocityNoise,
    Gated,
    Joined,
    LevelSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    LocalLevelNoise,
    PositionSample,
    Sample,
    Settling,
    Transition,
    joined,
    summed,
)
from filters.without_missing import without_missing
from objectives import Data, InnovationLikelihood, score, score_and_gradient
from tests.oracles import Model, kalman_nats

RNG = np.random.default_rng(7)
LIKELIHOOD = InnovationLikelihood()
F = np.array([[1.0, 0.1], [-0.1, 0.9]])
RECORD = RNG.normal(size=(1500, 2)) + 3.0
PUSHES = RNG.normal(size=(1500, 1))
FULL = np.array([[1.0, 0.3], [0.3, 0.5]])
ROW = np.array([[1.0, 0.0], [0.5, 1.0]])
POINT = np.array([-1.0, 0.5])


def build(point, F=F, H=ROW, B=None):
    q, r = jnp.exp(point)
    step = Transition(jnp.asarray(F), jnp.eye(2), q * jnp.eye(2), B)
    return LinearModel(step, jnp.asarray(H), r * FULL[: len(H), : len(H)], jnp.eye(2), jnp.ones(2))


def with_holes(where):
    z = RECORD.copy()
    z[where] = np.nan
    return z


HOLES = {
    "none": RECORD,
    "at the start": with_holes(np.s_[:200]),
    "one": with_holes((700, 1)),
    "a gap": with_holes(np.s_[600:900]),
    "one channel": with_holes(np.s_[:, 1]),
    "every tenth": with_holes(np.s_[::10]),
    "all": with_holes(np.s_[:]),
}


@jax.jit
def nats_and_short(z):
    data = Sample(z), jnp.zeros(len(z))
    return summed(Settling(LinearKalman(), 64), build(POINT), data, LIKELIHOOD.added)


@pytest.mark.parametrize("holes", HOLES)
def test_likelihood_is_that_of_the_textbook_loop(holes):
    z = HOLES[holes]
    (nats, numbers), short = nats_and_short(jnp.asarray(z))
    q, r = np.exp(POINT)
    model = Model(F, q * np.eye(2), ROW, r * FULL, np.eye(2), np.ones(2))
    assert numbers == np.isfinite(z).sum()
    assert abs(nats - kalman_nats(model, z)) <= 1e-12 * abs(nats)
    assert short == {"none": 1344, "one": 1152, "a gap": 896, "at the start": 1152}.get(holes, 0)


def test_a_known_input_takes_part():
    data = Sample(jnp.asarray(RECORD), jnp.asarray(PUSHES)), jnp.zeros(len(RECORD))
    B = np.array([[0.3], [1.0]])
    (nats, _), short = summed(
        Settling(LinearKalman(), 64), build(POINT, B=B), data, LIKELIHOOD.added
    )
    q, r = np.exp(POINT)
    model = Model(F, q * np.eye(2), ROW, r * FULL, np.eye(2), np.ones(2))
    assert abs(nats - kalman_nats(model, RECORD, PUSHES @ B.T)) <= 1e-12 * abs(nats)
    assert short > 0


def long_and_short(filter, build, inputs, point, block=64, ways=("forwards",)):
    """Value and gradient the long way, and the short way in some directions."""
    data = Data(inputs, jnp.zeros(len(jax.tree.leaves(inputs)[0])))
    each = [(filter, "forwards"), *((Settling(filter, block), way) for way in ways)]

    @partial(jax.jit, static_argnums=(0, 1))
    def found(filter, way, point):
        return score_and_gradient(filter, LIKELIHOOD, build, point, data, way=way)

    return [found(filter, way, point) for filter, way in each]


def agree(long, *short):
    for value, slope in short:
        np.testing.assert_allclose(value, long[0], rtol=1e-12)
        np.testing.assert_allclose(slope, long[1], rtol=0, atol=1e-10 * np.abs(long[1]).max())


FILTERS = {
    "local level": (
        LocalLevel(dt=0.5),
        lambda point: LocalLevelNoise(*jnp.exp(point)),
        LevelSample(jnp.asarray(RECORD[:, 0])),
    ),
    "constant velocity of two axes": (
        ConstantVelocity(dt=0.5, axes="xy"),
        lambda point: ConstantVelocityNoise(*jnp.exp(point)),
        PositionSample(*jnp.asarray(RECORD.T)),
    ),
    "a start of which nothing is known": (
        LinearKalman(diffuse=(0, 1)),
        build,
        Sample(jnp.asarray(HOLES["a gap"])),
    ),
}


@pytest.mark.parametrize("name", FILTERS)
def test_any_linear_filter_takes_the_short_way(name):
    filter, build, inputs = FILTERS[name]
    data = inputs, jnp.zeros(1500)
    short = jax.jit(
        lambda point: summed(Settling(filter, 64), build(point), data, LIKELIHOOD.added)[1]
    )
    assert short(POINT) >= 800
    agree(*long_and_short(filter, build, inputs, POINT))


def test_backwards_the_gradient_is_the_same():
    filter, build, _ = FILTERS["local level"]
    inputs = LevelSample(jnp.asarray(HOLES["a gap"][:, 0]))
    agree(*long_and_short(filter, build, inputs, POINT, ways=("backwards",)))


@settings(max_examples=100, deadline=None)
@given(
    F=st.lists(st.floats(-1.2, 1.2), min_size=4, max_size=4),
    sight=st.sampled_from([(1.0, 0.0), (0.0, 1.0), (0.0, 0.0), (1.0, -2.0)]),
    q=st.sampled_from([0.0, 1e-12, 1e-4, 1.0]),
    start=st.sampled_from([0.0, 1e-6, 1.0, 1e6]),
    gaps=st.lists(st.tuples(st.integers(0, 511), st.integers(1, 80)), max_size=3),
)
def test_systems_of_any_kind(F, sight, q, start, gaps):
    # Beyond, P after a gap is singular in double precision, and no two orders of rounding agree.
    growth = np.abs(np.linalg.eigvals(np.reshape(F, (2, 2)))).max() ** 2
    assume(growth ** sum(count for _, count in gaps) < 1e8)
    z = RECORD[:512, :1].copy()
    for first, count in gaps:
        z[first : first + count] = np.nan
    long, short = _any(*map(jnp.asarray, (np.reshape(F, (2, 2)), [sight], q, start, z)))
    value, slope = long
    if np.isfinite(value) and np.isfinite(slope).all():
        np.testing.assert_allclose(short[0], value, rtol=1e-12)
        np.testing.assert_allclose(short[1], slope, rtol=0, atol=1e-10 * np.abs(slope).max())


@jax.jit
def _any(F, H, q, start, z):
    """Derivatives by noise, a transition and the start: at a point where nothing may be at rest."""
    point = jnp.array([q, 1.0, F[0, 0], start])

    def build(point):
        q, r, f, p = point
        step = Transition(F.at[0, 0].set(f), jnp.eye(2), q * jnp.eye(2))
        return LinearModel(step, H, r[None], p * jnp.eye(2), jnp.ones(2))

    data = Data(Sample(z), jnp.zeros(len(z)))
    both = partial(score_and_gradient, objective=LIKELIHOOD, build=build, z=point, data=data)
    return both(LinearKalman()), both(Settling(LinearKalman(), 16))


@pytest.mark.parametrize(
    ("F", "start", "why"),
    [
        (np.array([[1.0, 0.0], [0.0, 0.5]]), 0.0, "a start that is known, of what is not seen"),
        (np.diag([1 - 1e-6, 0.5]), 0.0, "an error that is forgotten within a million samples"),
    ],
)
def test_a_covariance_that_is_constant_alone_does_not_settle(F, start, why):
    """Its derivative by the noise still grows."""

    def build(point):
        step = Transition(jnp.asarray(F), jnp.eye(2), jnp.diag(jnp.array([point[0], 0.0])))
        return LinearModel(
            step, jnp.array([[1.0, 0.0]]), jnp.ones(1), start * jnp.eye(2), jnp.zeros(2)
        )

    inputs = Sample(jnp.asarray(RECORD[:1024, :1]))
    agree(*long_and_short(LinearKalman(), build, inputs, jnp.array([0.0]), block=16))


@pytest.mark.parametrize(
    ("filter", "inputs"),
    [
        (Joined(LinearKalman()), joined([Sample(jnp.asarray(RECORD))])),
        (Gated(LinearKalman(), (((0, 0),), ((0, 1),)), 3.0), Sample(jnp.asarray(RECORD))),
        (
            LinearKalman(),
            Sample(
                jnp.asarray(RECORD),
                transition=Transition(*(jnp.broadcast_to(jnp.eye(2), (1500, 2, 2)),) * 3),
            ),
        ),
    ],
    ids=["records end to end", "a gate", "transitions of the samples"],
)
def test_where_the_gains_depend_on_samples_there_is_no_short_way(filter, inputs):
    data = Data(inputs, jnp.zeros(1500))
    assert summed(Settling(filter, 64), build(POINT), data, LIKELIHOOD.added) is None
    found = [score(each, LIKELIHOOD, build(POINT), data) for each in (filter, Settling(filter, 64))]
    assert found[0] == found[1]


def test_short_records_are_taken_one_by_one():
    data = Data(Sample(jnp.asarray(RECORD)), jnp.zeros(1500))
    assert summed(Settling(LinearKalman()), build(POINT), data, LIKELIHOOD.added) is None


@pytest.mark.parametrize(
    "asked",
    [
        lambda u: jnp.where(jnp.isnan(u).any(), 0.0, u),
        lambda u: jnp.where(~jnp.isnan(u) | False, u, 1.0),
        lambda u: jnp.where(jnp.isnan(u) & (u > 0), 1.0, u),
        lambda u: u * jnp.where(jnp.isnan(jnp.stack([u, u])).any(axis=0), 0.0, 1.0),
    ],
)
def test_questions_of_missing_numbers_are_answered(asked):
    once = without_missing(lambda p, s, u: (s, asked(u)), 0.0, 0.0, jnp.ones(2))
    assert " ne " not in str(jax.make_jaxpr(once)(0.0, 0.0, jnp.ones(2)))
    np.testing.assert_array_equal(once(0.0, 0.0, jnp.array([3.0, -1.0]))[1], [3.0, -1.0])
