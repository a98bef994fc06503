"""A process that fits again and again lets go of what it compiled."""

import jax.numpy as jnp
import pytest

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
