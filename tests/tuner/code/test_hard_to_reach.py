"""Constants that only rare states show: counted, tiny, rounded, or gone from the formulas."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from tuner.code.array_step import Step
from tuner.code.bases import Bases, above, missing
from tuner.code.by_newton import by_newton
from tuner.code.by_one_entry import by_one_entry
from tuner.code.compared import Compared, ComparedNumbers
from tuner.code.covariances import symmetric
from tuner.code.detection import detected
from tuner.code.expected import expected, plain
from tuner.code.fields import Field
from tuner.code.form import form
from tuner.code.graph import Graph
from tuner.code.mutants import CHANGE, Mutant, limits_of
from tuner.code.preferred import Preferred
from tuner.code.program import as_graph
from tuner.code.states import by_node
from tuner.code.together import Inverses, Together
from tuner.code.trace import traced
from tuner.code.variations import varied

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


class Pointing(NamedTuple):
    x: Array


@dataclass(frozen=True)
class Aimed:
    """A vector that is corrected, and its angle with another one, held back just before zero."""

    def init(self, params):
        return Pointing(jnp.array([0.9, 0.3, 0.3, 0.1], jnp.asarray(params).dtype))

    def step(self, params, state, inputs):
        x = state.x + params * (inputs - state.x)
        aim = jnp.array([1.3, -0.7, 0.45, 2.1])
        cosine = x @ aim / jnp.sqrt((x @ x) * (aim @ aim))
        return Pointing(x), jnp.arccos(jnp.clip(cosine, -1.0 + 4e-15, 1.0 - 4e-15))


class Slow(NamedTuple):
    rate: Array
    time: Array


@dataclass(frozen=True)
class Still:
    """How long rates, in blocks of three, have been small and close to their mean.

    In the record they are zero at rest.
    """

    def init(self, params):
        zero = jnp.zeros(3, jnp.asarray(params).dtype)
        return Slow(zero, zero[0])

    def step(self, params, state, inputs):
        rate = state.rate + params * (inputs.mean(axis=0) - state.rate)
        close = ((inputs - rate) ** 2).sum() < 0.08**2
        small = jnp.abs(rate).max() < 0.05
        time = jnp.where(close & small, state.time + 0.25, 0.0)
        return Slow(rate, time), time


@pytest.mark.parametrize("precision", ["double", "float"])
def test_what_is_counted_is_brought_to_its_limit_alone(precision):
    steps = form("patient", Patient(), 0.5, RECORD, precision).reference.steps
    assert not steps.undetected


def test_a_limit_at_the_end_of_a_range_is_reached():
    """Three numbers have to be right to eight digits for the angle to be as good as zero."""
    record = np.array([0.9, 0.3, 0.3, 0.1]) + np.stack([RECORD * k for k in range(4)], axis=1)
    steps = form("aimed", Aimed(), 0.5, record).reference.steps
    assert not steps.undetected


def test_a_limit_is_reached_where_what_else_decides_stays_as_it_is(monkeypatch):
    for module in ("approach", "batches", "detection", "expected", "hidden", "limits", "search"):
        monkeypatch.setattr(f"tuner.code.{module}.LONG", 0)
    moving = np.repeat([0.0, 5.0], 30)[:, None] * np.stack([RECORD + 0.4 * k for k in range(3)], 1)
    blocks = np.repeat(moving[:, None], 3, axis=1)
    steps = form("still", Still(), 0.1, blocks).reference.steps
    assert not steps.undetected


def test_a_tiny_summand_shows_where_the_rest_is_no_larger():
    record = np.stack([RECORD, RECORD], axis=1)
    steps = form("even", Even(), 0.5, record).reference.steps
    assert not steps.undetected


def _bases(step, compared, given, count):
    return Bases([compared] * count, given, ComparedNumbers(step, [compared]))


def test_one_entry_passes_a_limit_and_all_others_stay():
    step = Step(as_graph(traced(Patient(), 0.5, 0.1, "double")))
    nodes = step.graph.nodes
    (k,) = (k for k in step.order if nodes[k].op == "lt")
    x, limit = nodes[k].args
    given = [np.array([3.0, -1.0]), np.array([0.0, 25.0]), np.array([9.0, 8.0])]
    bases = _bases(step, Compared(k, x, limit), given, 2)
    side = np.array([-1.0, 1.0])
    found, there = by_one_entry(step, 2, bases, side)
    assert there.all()
    assert not missing(step, 2, found, bases, side)[0].any()
    assert found[0].tolist() == given[0].tolist()
    assert found[2].tolist() == given[2].tolist()
    assert found[1][0] > 10 > found[1][1]


def test_a_step_is_no_closer_where_its_decision_does_not_matter():
    step = Step(as_graph(traced(Patient(), 0.5, 0.1, "double")))
    nodes = step.graph.nodes
    (k,) = (k for k in step.order if nodes[k].op == "lt")
    assert step.needed[k]
    given = [np.array([3.0, 3.0]), np.array([0.0, 0.0]), np.array([9.0, 3.5])]
    compared = Compared(k, *nodes[k].args, step.needed[k])
    gap, _ = missing(step, 2, given, _bases(step, compared, given, 1), np.array([-1.0]))
    assert np.isfinite(gap).tolist() == [True, False]


def sine_of_pitch():
    """A step whose result is the sine of the pitch of a quaternion of any length, held back."""
    graph = Graph()
    names = [graph.input(("state", name)) for name in "abcd"]
    a, b, c, d = names
    products = [graph.apply("mul", a, c), graph.apply("mul", b, d)]
    over = graph.apply("mul", graph.constant(2.0), graph.apply("sub", *products))
    under = graph.apply("mul", a, a)
    for one in names[1:]:
        under = graph.apply("add", under, graph.apply("mul", one, one))
    x, limit = graph.apply("div", over, under), graph.constant(1 - 1e-15)
    held = graph.apply("min", x, limit)
    program = SimpleNamespace(
        graph=graph,
        state=[Field("q", (4,), "real")],
        inputs=[],
        outputs=[],
        known={"state": [np.array(names, object)], "in": []},
        after=[np.array([held] * 4, object)],
        out=[],
    )
    return Step(program), Compared(held, x, limit)


def test_newtons_method_finds_the_end_of_a_range():
    step, compared = sine_of_pitch()
    draw = np.random.default_rng(0)
    given = [draw.normal(size=(20, 4))]
    bases = Bases([compared] * 20, given, ComparedNumbers(step, [compared]))
    found = by_newton(step, 1, bases, -np.ones(20), draw)
    x, limit, _ = above(step, 1, found, bases)
    assert (x >= limit).mean() > 0.7
    assert not (above(step, 1, given, bases)[0] >= limit).any()


def test_numbers_in_a_square_are_varied_one_by_one():
    draw = np.random.default_rng(0)
    block, P = draw.normal(size=(40, 3, 3)), np.array([[[2.0, 1.0], [1.0, 3.0]]] * 40)
    for _ in range(5):
        block_after, P_after = varied(draw, [block, P])
        ratio = block_after / block
        assert any(np.ptp(ratio[k]) > 1e-3 for k in range(40))
        assert np.allclose(P_after / P, (P_after / P)[:, :1, :1])
    uneven = P + np.array([[0.0, 1e-17], [0.0, 0.0]])
    assert symmetric(uneven)
    assert not symmetric(block)


def test_states_are_preferred_in_which_what_constants_need_is_so():
    step = Step(as_graph(traced(Patient(), 0.5, 0.1, "double")))
    nodes = step.graph.nodes
    counted = [one for one in step.mutants if nodes[nodes[one.node].args[one.at]].value == 10.0]
    assert counted
    inputs = np.where(np.arange(100) % 20 == 19, 50.0, 0.1)
    drawn = [np.zeros(100), np.zeros(100), inputs]
    preferred = Preferred(step, counted)
    found = preferred.of(drawn, counted, 10)
    assert [len(x) for x in found] == [10, 10, 10]
    assert (found[2] > 1).sum() == 5
    assert (preferred.of(drawn, [], 10)[2] > 1).sum() == 0


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
    bases = _bases(step, Compared(9, x, limit), [], 1)
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
