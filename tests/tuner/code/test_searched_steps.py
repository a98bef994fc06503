"""Parts of the search for single steps, each by itself."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from tuner.code.chosen import Chosen
from tuner.code.faint import Faint
from tuner.code.fields import Field
from tuner.code.form import form
from tuner.code.graph import Graph
from tuner.code.mutants import Mutant, mutants_of, uses_of
from tuner.code.program import as_graph
from tuner.code.rounding_errors import Noise
from tuner.code.states import Around
from tuner.code.steps import _roots
from tuner.code.together import Together
from tuner.code.trace import traced


@dataclass(frozen=True)
class Curved:
    """A sum of which a thousandth of the last term is hardly more than its rounding."""

    def init(self, params):
        return jnp.zeros((), jnp.asarray(params).dtype)

    def step(self, params, state, inputs):
        x = state + params * (inputs - state)
        return x, jnp.cos(x) + 1.5 + 1e-11 * jnp.sin(x)


def test_errors_are_small_and_of_their_own():
    row, begin = Noise(np.random.default_rng(0), 1e-3, 3).row(50, 40)
    flat = np.array([row[at : at + 150] - 1 for at in begin])
    assert flat.shape == (40, 150)
    assert np.abs(flat).max() <= 1e-3
    alike = np.corrcoef(flat) - np.eye(len(flat))
    assert np.abs(alike).max() < 0.5
    assert np.allclose(flat.std(), 1e-3 / np.sqrt(3), rtol=0.1)


def test_some_steps_stay_at_rest():
    states, samples = [np.arange(20.0) + 1], [np.arange(20.0) + 101]
    around = Around([Field("x", (), "real")], [Field("u", (), "real")], states, samples, 5)
    (x,), (u,) = around.drawn(np.random.default_rng(0), 400)
    still = (x >= 16) & (u - x == 100) & (x == np.round(x))
    assert still.sum() > 400 * 0.08
    nothing = Around(around.state, around.inputs, states, samples)
    (x,), (u,) = nothing.drawn(np.random.default_rng(0), 400)
    assert np.isfinite(x).all()


def test_both_halves_of_a_symmetric_matrix_are_compared():
    field = Field("P", (2, 2), "real", half=True)
    program = SimpleNamespace(state=[field], outputs=[])
    own, other = _roots(program, [np.array([[[1.0, 2.0], [3.0, 4.0]]])], [])
    assert own.ravel().tolist() == [1.0, 2.0, 4.0]
    assert other.ravel().tolist() == [1.0, 3.0, 4.0]


def test_equal_constants_of_one_operation_are_one():
    graph = Graph()
    inputs = [graph.input(k) for k in range(3)]
    half = graph.constant(0.5)
    first = [graph.apply("mul", x, half) for x in inputs]
    between = inputs[0]
    for _ in range(80):
        between = graph.apply("sin", between)
    last = graph.apply("mul", between, half)
    mutants = [Mutant(k, graph.nodes[k].args.index(half)) for k in (*first, last)]
    order = graph.reached([*first, last])
    program = SimpleNamespace(precision="double")
    step = SimpleNamespace(graph=graph, order=order, mutants=mutants, program=program)
    together = Together(step)
    sizes = [np.array([0.9, 1.4, 0.1]), np.array([0.1, 1.4, 0.9]), np.array([0.2, 1.4, 0.2])]
    together.look(dict(zip(mutants, [*sizes, np.array([1.9, 0.0, 0.0])], strict=True)))
    together.take([np.array([10.0, 11.0, 12.0])], lambda at: [at])
    assert list(together.steps()) == [([11.0], [1], [0])]
    together.look({mutants[-1]: np.array([0.0, 2.5])})
    together.take([np.array([20.0, 21.0])], lambda at: [])
    assert list(together.steps()) == [([21.0], [], [3]), ([11.0], [1], [0])]
    alike = [*sizes, np.array([0.9, 1.4, 0.1])]
    together.look({one: 10 * size for one, size in zip(mutants, alike, strict=True)})
    together.take([np.array([30.0, 31.0, 32.0])], lambda at: [])
    assert list(together.steps()) == [([31.0], [], [0, 3]), ([31.0], [], [3, 0])]


def test_few_steps_show_what_many_do():
    chosen = Chosen()
    for shown in ("ab", "bc", "cd", "abd", "e"):
        chosen.take([np.array(len(chosen.steps))], shown)
    chosen.take([np.array(5)], [], ["f", "g"])
    everywhere = [True] * 6
    assert chosen.fewest(1, everywhere) == [3]
    assert chosen.fewest(4, everywhere) == [1, 3, 4, 5]
    assert chosen.fewest(9, everywhere) == list(range(6))
    assert chosen.fewest(3, [True, True, True, False, True, True]) == [0, 2, 4]


def test_steps_may_show_more_when_they_are_judged():
    chosen = Chosen()
    for shown in ("ab", "a", "b"):
        chosen.take([np.zeros(1)], shown)
    chosen.take([np.zeros(1)])
    assert chosen.fewest(1, [True] * 4) == [0]
    chosen.show(["c", "d"], np.array([[False, True, False, True], [False, False, False, True]]))
    assert chosen.fewest(2, [True] * 4) == [0, 3]


def test_of_constants_that_hardly_show_the_best_steps_are_kept():
    faint, one, other = Faint(), Mutant(1, 0), Mutant(2, 0)
    draw = np.random.default_rng(0)
    sizes = {one: draw.uniform(0.0, 2.0, (3, 20)), other: np.full((3, 20), 0.6)}
    for k in range(3):
        moves = {key: rows[k] for key, rows in sizes.items()}
        faint.look(moves, [np.arange(20.0) + 100 * k])
    assert faint.mutants == [one]
    best = np.argsort(-sizes[one].ravel())[:6]
    assert [step[0] for step in faint.steps] == [float(100 * (k // 20) + k % 20) for k in best]
    faint.leave([other])
    assert not faint.mutants
    assert not faint.steps


def test_a_constant_that_only_just_shows_is_among_the_steps(monkeypatch):
    for module in ("batches", "detection", "expected", "hidden", "search"):
        monkeypatch.setattr(f"tuner.code.{module}.LONG", 0)
    kept = []
    shows = Chosen.show
    monkeypatch.setattr(Chosen, "show", lambda *given: (kept.append(given[1:]), shows(*given)))
    steps = form("curved", Curved(), 0.5, 0.1 * np.sin(np.arange(60.0))).reference.steps
    ((mutants, where),) = kept
    assert len(mutants) == 1
    assert where.any()
    assert mutants[0] not in steps.undetected


def test_results_that_several_operations_use_are_looked_at_where_each_does():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    twice = graph.apply("mul", x, graph.constant(2.5))
    once = graph.apply("mul", y, graph.constant(0.3))
    roots = [graph.apply("sin", twice), graph.apply("mul", twice, y), graph.apply("cos", once)]
    order = graph.reached(roots)
    found = uses_of(graph, order, list(mutants_of(graph, order)))
    assert {one.node for one in found} == set(roots[:2])
    assert all(graph.nodes[one.node].args[one.at] == twice for one in found)


def test_some_huge_covariances_have_variances_alone():
    states = [np.array([[[2.0, 1.0], [1.0, 3.0]]] * 20)]
    around = Around([Field("P", (2, 2), "real", half=True)], [], states, [], wide=7.0)
    (P,), _ = around.drawn(np.random.default_rng(0), 200)
    huge = (P[:, 0, 1] == 0) & (P[:, 0, 0] > 0)
    assert 0.3 < np.mean(huge) < 0.7
    assert np.allclose(P[huge, 1, 1] / P[huge, 0, 0], 1.5)
    assert (P[huge, 0, 0] >= 2e8).all()


class Turning(NamedTuple):
    matrix: Array
    P: Array


@dataclass(frozen=True)
class Turned:
    """A matrix that begins as a unit matrix and turns, and one that stays symmetric."""

    def init(self, params):
        return Turning(jnp.eye(2), jnp.eye(2))

    def step(self, params, state, inputs):
        turn = jnp.array([[1.0, -1.0], [1.0, 1.0]]) * params + inputs * jnp.eye(2)
        return Turning(turn @ state.matrix, turn @ state.P @ turn.T), state.P[0, 1]


def test_a_matrix_that_turns_is_told_before_there_is_a_graph(monkeypatch):
    from tuner.code import program

    tries, attempt = [], program._attempt

    def counted(traced, half, *rest):
        tries.append(set(half))
        return attempt(traced, half, *rest)

    monkeypatch.setattr(program, "_attempt", counted)
    found = as_graph(traced(Turned(), 0.3, 0.7, "double"))
    assert tries == [{"P"}]
    assert [field.half for field in found.state] == [False, True]
