"""The loop for a way back is the loop: whole, in parts, with what is invariant taken out."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import LinearKalman, LinearModel, Sample, Transition, run, run_kept
from filters.invariant import invariant

Z = np.random.default_rng(5).normal(size=(23, 1))
Z[7] = np.nan


def model(point):
    q, r = jnp.exp(point)
    step = Transition(jnp.array([[1.0, 0.1], [0.0, 0.9]]), jnp.eye(2), q * jnp.eye(2))
    return LinearModel(step, jnp.ones((1, 2)), r[None], jnp.eye(2), jnp.zeros(2))


def loss(over, point, z):
    state, outputs = over(LinearKalman(), model(point), Sample(z))
    return (outputs.x**2).sum() + jnp.log(outputs.variance + 1).sum() + (state.P**2).sum()


@pytest.mark.parametrize("length", [3, 16, 23])
@pytest.mark.parametrize("way", [{}, {"parts": True}, {"most": 0}])
def test_it_is_the_same_loop(length, way):
    """A length that is a square, and one that leaves samples over."""
    point, z = jnp.array([0.3, -0.2]), Z[:length]
    plain = jax.jit(jax.value_and_grad(partial(loss, run)))(point, z)
    kept = jax.jit(jax.value_and_grad(partial(loss, partial(run_kept, **way))))(point, z)
    # The same operations, of which the compiler may fuse others into one rounding.
    np.testing.assert_allclose(kept[0], plain[0], rtol=1e-14)
    np.testing.assert_allclose(kept[1], plain[1], rtol=1e-12)


def test_what_follows_from_parameters_leaves_the_loop():
    def step(params, state, sample):
        heavy = jnp.sin(params["a"]) @ jnp.sin(params["a"]).T
        return state + heavy @ sample, {"sum": state.sum() * params["b"], "constant": heavy}

    params = {"a": jnp.eye(3), "b": 2.0}
    inner = jax.make_jaxpr(invariant(step, params, jnp.zeros(3), jnp.ones(3)))
    names = [eqn.primitive.name for eqn in inner(jnp.zeros(3), jnp.ones(3)).eqns]
    assert "sin" not in names
    assert names.count("dot_general") == 1
    once = invariant(step, params, jnp.zeros(3), jnp.ones(3))
    for found, wanted in zip(
        jax.tree.leaves(once(jnp.ones(3), jnp.ones(3))),
        jax.tree.leaves(step(params, jnp.ones(3), jnp.ones(3))),
        strict=True,
    ):
        np.testing.assert_allclose(found, wanted, rtol=1e-15)


def test_numbers_that_are_no_arrays_stay_what_they_are():
    """A parameter that is a plain number may decide what is done."""

    def step(params, state, sample):
        return (state + sample if params[0] > 1 else state), params[1] * sample

    once = invariant(step, (2, jnp.array(3.0)), jnp.zeros(()), jnp.zeros(()))
    assert [float(x) for x in once(jnp.array(1.0), jnp.array(1.0))] == [2.0, 3.0]
