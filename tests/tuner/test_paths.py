"""Which way a gradient goes, and that it does not matter to its value."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import (
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    Gated,
    Lanes,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
)
from objectives import Data, InnovationLikelihood
from tuner import Fixed, Positive, Problem, Space
from tuner.problem.paths import way_of

N, STATES = 30, 4
NAMES = ("q0", "q1", "q2", "q3", "r")
F = np.eye(STATES) + 0.1 * np.eye(STATES, k=1)
Z = np.random.default_rng(1).normal(size=(N, 1)).cumsum(axis=0)
Z[11] = np.nan


def linear(values):
    q = jnp.stack([values[name] for name in NAMES[:STATES]])
    step = Transition(jnp.asarray(F), jnp.eye(STATES), jnp.diag(q))
    H = jnp.ones((1, STATES))
    return LinearModel(step, H, values["r"][None], jnp.eye(STATES), jnp.zeros(STATES))


def bent(values):
    q = jnp.stack([values[name] for name in NAMES[:STATES]])
    return ExtendedModel(q, values["r"][None], jnp.zeros(STATES), jnp.eye(STATES))


def moved(q, x, u):
    return jnp.asarray(F) @ jnp.sin(x)


def disturbed(q, x, u):
    return jnp.diag(q)


def seen(q, x, u):
    return jnp.sin(x).sum()[None]


def problem(filter=None, build=linear, inputs=None, free=NAMES, **settings):
    names = dict.fromkeys((*NAMES, *free))
    space = Space.of(**{k: Positive(1.0, 1e-3, 1e3) if k in free else Fixed(1.0) for k in names})
    inputs = Sample(Z) if inputs is None else inputs
    filter = LinearKalman() if filter is None else filter
    truth = np.zeros(N) if isinstance(filter, Lanes) else Z
    data = Data(inputs, truth)
    return Problem("one", space, filter, build, InnovationLikelihood(), data, **settings)


KINDS = {
    "linear": problem(),
    "several records": problem(Lanes(LinearKalman(), 2), inputs=Sample(np.stack([Z, -Z], axis=1))),
    "extended": problem(ExtendedKalman(moved, disturbed, seen), bent, ExtendedSample(Z)),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("way", ["backwards", "backwards in parts"])
def test_all_ways_lead_to_the_same_gradient(kind, way):
    given = KINDS[kind]
    z = given.space.start() + np.linspace(-0.5, 0.5, len(NAMES))
    forth = replace(given, way="forwards").value_and_gradient(z)
    back = replace(given, way=way).value_and_gradient(z)
    np.testing.assert_allclose(back[0], forth[0], rtol=1e-13)
    np.testing.assert_allclose(back[1], forth[1], rtol=0, atol=1e-12 * np.abs(forth[1]).max())


def test_many_parameters_go_backwards_and_few_forwards():
    assert problem().gradient_way == "backwards"
    assert problem(free=NAMES[:4]).gradient_way == "forwards"
    assert KINDS["several records"].gradient_way == "backwards"
    assert KINDS["extended"].gradient_way == "forwards"


@pytest.mark.parametrize(
    ("states", "free", "way"),
    [
        (4, 5, "forwards"),
        (4, 6, "backwards in parts"),
        (8, 3, "forwards"),
        (8, 4, "backwards in parts"),
        (9, 2, "forwards"),
        (9, 3, "backwards in parts"),
    ],
)
def test_an_extended_filter_goes_backwards_where_that_pays_for_its_compilation(states, free, way):
    zero, one = np.zeros(states), np.ones(states)
    model = ExtendedModel(one, np.ones(1), zero, np.diag(one))
    assert way_of(ExtendedKalman(moved, disturbed, seen), model, free) == way


def test_a_way_may_be_forced_and_a_gate_goes_forwards():
    assert problem(way="forwards").gradient_way == "forwards"
    assert problem(free=NAMES[:1], way="backwards").gradient_way == "backwards"
    gated = problem(Gated(LinearKalman(), (((0, 0),),)), free=NAMES)
    assert gated.gradient_way == "forwards"


def halved(q, x, u):
    """A loop whose length is not known."""
    return jax.lax.while_loop(lambda y: jnp.abs(y).max() > 3, lambda y: y / 2, jnp.asarray(F) @ x)


def rooted(q, x, u):
    """A root whose slope is infinite where it is not taken."""
    return jnp.where(x[:1] > 100, jnp.sqrt(jnp.maximum(x[:1] - 100, 0.0)), x[:1])


def many(move, measure):
    filter = ExtendedKalman(move, disturbed, measure)
    return problem(filter, wide, ExtendedSample(Z), free=(*NAMES, "p"))


def wide(values):
    return bent(values)._replace(P0=values["p"] * jnp.eye(STATES))


def test_what_does_not_turn_round_goes_forwards():
    assert many(moved, seen).gradient_way == "backwards in parts"
    assert many(halved, seen).gradient_way == "forwards"


def test_where_the_way_back_has_no_number_the_way_forth_is_taken():
    given = many(moved, rooted)
    z = given.space.start()
    assert given.gradient_way == "backwards in parts"
    assert not np.isfinite(replace(given, way="backwards").by_xla(z)[1]).all()
    forth = replace(given, way="forwards").by_xla(z)
    np.testing.assert_array_equal(given.by_xla(z)[1], forth[1])
    assert np.isfinite(forth[1]).all()
