"""A process that fits again and again lets go of what it compiled."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import pytest

from objectives import Data, score, score_and_gradient
from tests.tuner.helpers import bowl, problem
from tuner.problem import kept_programs
from tuner.problem.kept_programs import forget_old_ones


def test_programs_are_let_go_where_they_are_many(monkeypatch):
    posed = problem(bowl)
    value = posed.value(jnp.zeros(2))
    kept = sum(each._cache_size() for each in kept_programs._compiled())
    assert kept
    monkeypatch.setattr(kept_programs, "MOST", kept)
    forget_old_ones()
    assert sum(each._cache_size() for each in kept_programs._compiled()) == kept
    monkeypatch.setattr(kept_programs, "MOST", kept - 1)
    forget_old_ones()
    assert sum(each._cache_size() for each in kept_programs._compiled()) == 0
    assert posed.value(jnp.zeros(2)) == pytest.approx(value, rel=1e-12)


@dataclass(frozen=True)
class Counting:
    """A gain on the input that counts how often its step is traced."""

    traced = 0

    def init(self, params):
        return 0.0 * params

    def step(self, params, state, inputs):
        type(self).traced += 1
        state = state + params * (inputs - state)
        return state, state


def test_a_step_is_traced_once_for_value_and_gradient():
    u = jnp.linspace(0.0, 1.0, 9)

    def squares(outputs, truth):
        return ((outputs - truth) ** 2).sum()

    data, two = Data(u, u**2), jnp.array([0.3])
    for _ in range(2):
        value = jax.jit(lambda z: score(Counting(), squares, z[0], data))(two)
        both = jax.jit(
            lambda z: score_and_gradient(Counting(), squares, lambda at: at[0], z, data)
        )(two)
    assert Counting.traced == 1
    assert both[0] == pytest.approx(float(value), rel=1e-15)
