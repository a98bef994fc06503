"""Constants that only rare states show: counted, tiny, rounded, or gone from the formulas."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from tuner.code.array_step import Step
from tuner.code.bases import Bases, missing
from tuner.code.by_one_entry import by_one_entry
from tuner.code.compared import ComparedNumbers
from tuner.code.detection import detected
from tuner.code.expected import expected, plain
from tuner.code.fields import Field
from tuner.code.form import form
from tuner.code.graph import Graph
from tuner.code.mutants import CHANGE, Mutant, limits_of
from tuner.code.program import as_graph
from tuner.code.states import by_node
from tuner.code.together import Inverses, Together
from tuner.code.trace import traced

RECORD = 0.1 * np.sin(np.arange(60.0))


class Counted(NamedTuple):
    x: Array
    count: Array


@dataclass(frozen=True)
class Patient:
    """What refuses far measurements, ten in a row at most; the record has none."""

    def init(self, params):
        zero = jnp.zeros((), jnp.asarray(params).dtype)
        return Counted(zero, zero)

    def step(self, params, state, inputs):
        far = (inputs - state.x) ** 2 > 16.0
        refused = far & (state.count < 10.0)
        x = jnp.where(refused, state.x, state.x + params * (inputs - state.x))
        return Counted(x, jnp.where(far, state.count + 1, 0.0)), x


class Place(NamedTuple):
    x: Array


@dataclass(frozen=True)
class Even:
    """A step of one length but where there is nothing to go."""

    def init(self, params):
        return Place(jnp.ones(2, jnp.asarray(params).dtype))

    def step(self, params, state, inputs):
        apart = state.x - inputs
        size = jnp.sqrt(apart @ apart + 2.5e-24)
        return Place(state.x - params * apart / size), state.x


@dataclass(frozen=True)
class Wrapped:
    """An angle near zero, brought back where it is beyond half a turn."""

    def init(self, params):
        return Place(jnp.zeros((), jnp.asarray(params).dtype))

    def step(self, params, state, inputs):
        x = state.x + params * inputs
        turns = jnp.round(x / 6.2)
        return Place(x - 6.0 * turns), x


@pytest.mark.parametrize("precision", ["double", "float"])
def test_what_is_counted_is_brought_to_its_limit_alone(precision):
    steps = form("patient", Patient(), 0.5, RECORD, precision).reference.steps
    assert not steps.undetected


def test_a_tiny_summand_shows_where_the_rest_is_no_larger():
    record = np.stack([RECORD, RECORD], axis=1)
    steps = form("even", Even(), 0.5, record).reference.steps
    assert not steps.undetected


def test_one_entry_passes_a_limit_and_all_others_stay():
    step = Step(as_graph(traced(Patient(), 0.5, 0.1, "double")))
    nodes = step.graph.nodes
    (k,) = (k for k in step.order if nodes[k].op == "lt")
    x, limit = nodes[k].args
    given = [np.array([3.0, -1.0]), np.array([0.0, 25.0]), np.array([9.0, 8.0])]
    bases = Bases([(k, x, limit)] * 2, given, ComparedNumbers(step, [(x, limit)]))
    side = np.array([-1.0, 1.0])
    found, there = by_one_entry(step, 2, bases, side)
    assert there.all()
    assert not missing(step, 2, found, bases, side)[0].any()
    assert found[0].tolist() == given[0].tolist()
    assert found[2].tolist() == given[2].tolist()
    assert found[1][0] > 10 > found[1][1]


def test_what_cannot_pass_a_limit_counts_as_closer_the_closer_it_is():
    graph = Graph()
    x, limit = graph.input(("state", "x")), graph.constant(2.0)
    program = SimpleNamespace(
        graph=graph,
        state=[Field("x", (), "real")],
        inputs=[],
        outputs=[],
        known={"state": [np.array(x, object)], "in": []},
        after=[np.array(graph.apply("min", x, limit), object)],
        out=[],
    )
    step = Step(program)
    bases = Bases([(9, x, limit)], [], ComparedNumbers(step, [(x, limit)]))
    given = [np.array([0.0, 1.9, 1.99999, 2.0, 2.0001, 2.1])]
    gap, _ = missing(step, 1, given, bases, np.array([-1.0]))
    assert (np.diff(gap) < 0).all()
    assert gap[-1] == 0 < gap[-2]


def test_a_divisor_that_only_decides_shows_made_larger_and_smaller(monkeypatch):
    for module in ("batches", "detection", "hidden", "search"):
        monkeypatch.setattr(f"tuner.code.{module}.LONG", 0)
    found = form("wrapped", Wrapped(), 0.5, RECORD).reference.steps
    assert not found.undetected
    step = Step(as_graph(traced(Wrapped(), 0.5, 0.1, "double")))
    (factor,) = (one for one in step.limits if step.graph.nodes[one.node].op == "mul")
    given = by_node(step.program, found.states, found.samples)
    for change in (CHANGE, -CHANGE):
        assert detected(step, [factor], plain(step, given), 1.0, change=change).any()


def test_steps_of_inverses_are_those_that_show_them():
    step = Step(as_graph(traced(Wrapped(), 0.5, 0.1, "double")))
    inverses = Inverses(step)
    steps = [np.array([0.0, 3.1 * (1 - 5e-4), 3.1 * (1 + 5e-4)]), np.zeros(3)]
    given = by_node(step.program, steps[:1], steps[1:])
    right = expected(step, given, np.random.default_rng(0))
    inverses.look(right, steps, lambda at: [at])
    assert [(float(one[0]), shown[0]) for one, shown in inverses.steps()] == [(steps[0][2], 2)]


def test_constants_that_only_decide():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    rounded = graph.apply("round", graph.apply("mul", x, graph.constant(0.3)))
    far = graph.apply("lt", x, graph.constant(4.0))
    root = graph.choose(far, y, graph.apply("add", rounded, graph.apply("sin", y)))
    other = graph.apply("mul", y, graph.constant(0.7))
    order = graph.reached([root, other])
    found = limits_of(graph, order, [root, other])
    values = {float(graph.nodes[graph.nodes[one.node].args[one.at]].value) for one in found}
    assert values == {0.3, 4.0}


def test_half_of_mirrored_products_is_looked_at_where_formulas_have_none():
    graph = Graph()
    lost, gain = ([graph.input(f"{name}{k}") for k in range(2)] for name in "lk")
    half = graph.constant(0.5)

    def mean(i, j):
        mirrored = [graph.apply("mul", lost[i], gain[j]), graph.apply("mul", gain[i], lost[j])]
        return graph.apply("mul", graph.apply("add", *mirrored), half)

    off, diagonal = mean(0, 1), [mean(0, 0), mean(1, 1)]
    assert [set(graph.nodes[k].args) for k in diagonal] == [{lost[k], gain[k]} for k in range(2)]
    mutant = Mutant(off, graph.nodes[off].args.index(half))
    order = graph.reached([off, *diagonal])
    program = SimpleNamespace(precision="double")
    step = SimpleNamespace(graph=graph, order=order, mutants=[mutant], program=program)
    together = Together(step)
    assert set(together.whole) >= set(diagonal)
    assert len(set(together.whole.values())) == 1
