"""Compiled C works out a step as NumPy does, and so does what takes its derivatives."""

import jax
import numpy as np
import pytest

from tests.filters.battery import CASES
from tests.tuner.code.compiled import needed
from tuner.code import calculator as compiled
from tuner.code.array_step import Step
from tuner.code.by_compiler import Compiled
from tuner.code.by_numpy import InNumPy
from tuner.code.calculator import calculator
from tuner.code.evaluation import Sums
from tuner.code.form import ready
from tuner.code.graph import Graph
from tuner.code.mutants import OTHERWISE, WHOLE, Mutant, mutants_of
from tuner.code.operations import BINARY, LOGIC, UNARY
from tuner.code.rounding_errors import Noise
from tuner.compiler import NoCodeError

NUMBERS = np.array([0.0, -0.0, 0.3, -0.3, 1.0, 1.5, -2.5, 7.0, 1e300, np.inf, -np.inf, np.nan])
X, Y = (x.ravel() for x in np.meshgrid(NUMBERS, NUMBERS))
ROUNDED = 1e-15
"""Elementary functions of two libraries differ by their last digits."""


def in_both(graph, order):
    needed("gcc")
    return Compiled(calculator(), graph.nodes, order, order), InNumPy(graph, order, order)


def close(one, other, rtol=ROUNDED):
    x, y = np.broadcast_arrays(np.asarray(one, float), np.asarray(other, float))
    return np.allclose(x, y, rtol=rtol, atol=0, equal_nan=True)


def all_operations():
    """Every operation on real numbers, on truth values and on whole numbers."""
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    made = [graph.make(op, x) for op in UNARY if op not in ("not", "lgamma", "erf", "erfc")]
    made += [graph.make(op, x, y) for op in BINARY if op not in ("and", "or", "xor")]
    one, other = graph.make("lt", x, y), graph.make("isnan", y)
    made += [graph.make(op, one, other) for op in ("and", "or", "xor")]
    whole = [graph.convert(k, np.dtype(int)) for k in (x, y, one)]
    made += [graph.make(op, *whole[:2]) for op in ("div", "add", "max", "lt")]
    made += [graph.make("not", one), graph.choose(one, x, y), *whole]
    return graph, [*made, *(graph.convert(k, np.dtype(float)) for k in (one, *whole))]


def test_all_operations_are_numpys():
    graph, ends = all_operations()
    given = {graph.input("x"): X, graph.input("y"): Y}
    found, right = (one.values(given) for one in in_both(graph, graph.reached(ends)))
    assert {*found} == {*right}
    for k in ends:
        node = graph.nodes[k]
        assert close(found[k], right[k]), node.op
        assert found[k].dtype.kind == {"real": "f", "truth": "b", "whole": "i"}[node.kind]
        if node.op in LOGIC or node.op in ("add", "sub", "mul", "div", "sqrt", "max", "min"):
            assert close(found[k], right[k], 0), node.op


def test_of_many_states_some_nodes_alone(monkeypatch):
    needed("gcc")
    graph, ends = all_operations()
    order, x, y = graph.reached(ends), graph.input("x"), graph.input("y")
    whole = InNumPy(graph, order, order).values({x: X, y: Y})
    for cached in (1, 2_000, 100_000):
        monkeypatch.setattr("tuner.code.by_compiler._CACHED", cached)
        some = Compiled(calculator(), graph.nodes, order, ends[::3]).values({x: X, y: Y})
        assert [*some] == [*dict.fromkeys(ends[::3])]
        assert all(close(some[k], whole[k]) for k in ends[::3])
        assert all(some[k].dtype == whole[k].dtype for k in ends[::3])


def test_functions_of_single_numbers():
    graph = Graph()
    x = graph.input("x")
    ends = [graph.make(op, x) for op in ("erf", "erfc", "lgamma")]
    given = {x: np.array([0.2, 1.0, 3.7, 12.5])}
    found, right = (one.values(given) for one in in_both(graph, graph.reached(ends)))
    assert all(close(found[k], right[k]) for k in ends)


def test_some_states_of_all():
    graph, ends = all_operations()
    given = {graph.input("x"): X, graph.input("y"): Y}
    some = X > Y
    for one in in_both(graph, graph.reached(ends)):
        values = one.values(given)
        part = values.of(some)
        assert len(part) == len(values)
        assert all(close(part[k], np.broadcast_to(values[k], len(X))[some], 0) for k in ends)


def test_changes_of_constants_and_of_decisions():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    limit, half = graph.constant(0.9), graph.constant(0.5)
    parts = [graph.make(op, x, limit) for op in ("max", "min", "mul", "add", "div", "lt")]
    parts += [graph.make("div", half, y), graph.make("round", graph.make("mul", y, half))]
    chosen = graph.choose(parts[5], parts[0], parts[6])
    ends = [chosen, parts[7], graph.make("add", parts[1], graph.make("sin", parts[3])), *parts, y]
    order = graph.reached(ends)
    mutants = list(mutants_of(graph, order))
    mutants += [Mutant(k, OTHERWISE) for k in (*parts[:2], parts[3], parts[5], parts[7])]
    assert any(one.limit for one in mutants)
    rows = []
    for one in in_both(graph, order):
        known = one.values({x: X, y: Y})
        rows.append(one.changed(known, ends, mutants, 1.125))
        assert all(
            close(a, known[k], 0)
            for k, a in zip(ends, one.changed(known, ends, [], 2.0), strict=True)
        )
    assert rows[0][-1].ndim == 1
    for k, found, right in zip(ends, *rows, strict=True):
        assert found.ndim == right.ndim
        assert close(found, right), graph.nodes[k].op


def test_errors_of_rounding_are_drawn_alike():
    graph, ends = all_operations()
    given = {graph.input("x"): X, graph.input("y"): Y}
    for size in (0.0, 2.0**-30):
        found, right = (
            one.noisy(given, Noise(np.random.default_rng(3), size, 5), ends)
            for one in in_both(graph, graph.reached(ends))
        )
        for k in ends:
            assert np.shape(found[k]) == (5, len(X))
            assert close(found[k], right[k]), graph.nodes[k].op


def test_derivatives_of_every_operation():
    graph, _ = all_operations()
    x, y = graph.input("x"), graph.input("y")
    smooth = ("sin", "exp", "neg", "abs", "atan", "add", "sub", "mul", "div", "atan2", "pow", "max")
    ends = [graph.make(op, x) if op in UNARY else graph.make(op, x, y) for op in smooth]
    ends.append(graph.choose(graph.make("lt", x, y), ends[0], graph.make("mul", ends[8], ends[8])))
    order = graph.reached(ends)
    wanted = [Mutant(k, at) for k in ends for at in range(len(graph.nodes[k].args))]
    wanted += [Mutant(k, WHOLE) for k in ends]
    draw = np.random.default_rng(4)
    given = {x: draw.uniform(0.2, 2, 50), y: draw.uniform(0.2, 2, 50)}
    weights = draw.normal(size=(3, len(ends), 50))
    found, right = (
        one.slopes(one.values(given), Sums(ends, weights, wanted, 1e-3, 1e-6))
        for one in in_both(graph, order)
    )
    assert close(found, right, 1e-7)  # difference quotients divide by a millionth
    assert [not row.any() for row in found] == [one == Mutant(ends[-1], 0) for one in wanted]
    by_hand = (1e-3 * weights[:, 1] * given[x] * np.exp(given[x])) ** 2
    alone = [k for k, one in enumerate(wanted) if one == Mutant(ends[1], 0)]
    assert np.allclose(found[alone[0]], by_hand.sum(axis=0), rtol=1e-6)


@pytest.mark.parametrize("name", ["tilt, two-step", "heavy tails", "Madgwick, field"])
def test_the_same_steps_of_filters_without_a_compiler(name, monkeypatch):
    needed("gcc")
    (case,) = (one for one in CASES if one.name == name)
    record = jax.tree.map(np.asarray, case.inputs(case.measured))
    found = []
    for use in ("on", "off"):
        monkeypatch.setenv("TUNER_NATIVE", use)
        assert (calculator() is None) == (use == "off")
        found.append(ready(case.filter, case.build(case.point), record, "double"))
    steps = [one.form("same").reference.steps for one in found]
    assert steps[0].undetected == steps[1].undetected
    assert len(steps[0].samples[0]) == len(steps[1].samples[0])


@pytest.mark.parametrize("error", [NoCodeError("no"), OSError("no space left on device")])
def test_a_broken_compiler_changes_nothing(error, monkeypatch):
    def broken(*_):
        raise error

    monkeypatch.setattr(compiled, "library", broken)
    compiled._calculator.cache_clear()
    try:
        assert calculator() is None
        graph, ends = all_operations()
        step = Step.__new__(Step)
        step.__dict__["program"] = type("Program", (), {"graph": graph})()
        assert isinstance(step.part(graph.reached(ends), ends), InNumPy)
    finally:
        compiled._calculator.cache_clear()
