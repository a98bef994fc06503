"""The search for single steps in one precision after that in another."""

from dataclasses import replace

import jax
import numpy as np
import pytest

from tests.filters.battery import CASES
from tuner.code.array_step import Step
from tuner.code.form import prepared
from tuner.code.search import formulas


def both(name):
    """The filter traced in double and float, and what its steps show in double."""
    case = next(case for case in CASES if case.name == name)
    params = case.build(np.asarray(case.point, float))
    inputs = jax.tree.map(np.asarray, case.inputs(case.measured))
    double, single = (prepared(case.filter, params, inputs, one) for one in ("double", "float"))
    return double.tried(), single


@pytest.mark.parametrize(
    "name", ["gyroscope", "constant velocity, two axes", "tilt, two-step", "a gate"]
)
def test_float_shows_what_it_shows_alone_and_looks_at_less(name):
    double, single = both(name)
    alone, after = single.tried().steps, single.tried(double).steps
    assert after.detected >= alone.detected
    assert after.detected == double.steps.detected
    assert after.looked_at <= alone.looked_at + len(double.steps.states[0])
    assert after.idle <= set(after.undetected)
    assert [x.dtype for x in after.states] == [x.dtype for x in alone.states]


def test_only_the_same_formulas_give_anything_up():
    double, single = both("a gate")
    before, step = double.steps.before(), Step(single.program)
    assert before.formulas == formulas(step)
    assert before.given_up(step) == set(double.steps.undetected) != set()
    other = replace(before, formulas=[*before.formulas, "add"])
    assert other.given_up(step) == set()


def test_what_showed_in_double_is_looked_for_in_float():
    """Where double gave nothing up and has no steps, the search is that of float alone."""
    double, single = both("gyroscope")
    nothing = [x[:0] for x in double.steps.states], [x[:0] for x in double.steps.samples]
    empty = replace(double.steps, states=nothing[0], samples=nothing[1], undetected=[])
    found = single.tried(replace(double, steps=empty)).steps
    assert found.detected == single.tried().steps.detected
