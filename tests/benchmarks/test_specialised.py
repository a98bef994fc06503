"""Changes that leave formulas as they are where some decisions are known, told by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.identities import Identities
from benchmarks.specialised import Specialised
from tuner.code.array_step import Step
from tuner.code.graph import Graph
from tuner.code.mutants import mutants_of


def step_of(graph, *roots):
    program = SimpleNamespace(graph=graph, state=[], after=[], outputs=[], out=[])
    step = Step(program)
    step.__dict__["roots"] = list(roots)
    return step


def told(graph, value, *roots):
    """What is proven of each constant of a value."""
    step, nodes = step_of(graph, *roots), graph.nodes
    specialised = Specialised(step)
    return [
        specialised.tells(one, step.ways.way(one))
        for one in mutants_of(graph, step.order)
        if nodes[nodes[one.node].args[one.at]].value == value and not one.limit
    ]


def test_identities_are_those_of_fractions():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    one = graph.constant(1.0)
    inverse = graph.apply("div", one, graph.apply("add", x, y))
    shares = [graph.apply("mul", part, inverse) for part in (x, y)]
    whole = graph.apply("add", *shares)
    found = Identities(graph)
    assert found.same(whole, one)
    assert not found.same(shares[0], shares[1])
    turned = graph.apply("sub", graph.apply("add", x, y), y)
    assert found.same(graph.apply("sin", turned), graph.apply("sin", x))
    assert not found.same(graph.apply("sin", turned), graph.apply("cos", x))


@pytest.mark.parametrize(("factor", "expected"), [(2.0, "but for rounding"), (1.75, None)])
def test_a_factor_of_what_is_zero_but_for_rounding(factor, expected):
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    both = graph.apply("add", graph.apply("add", x, y), graph.apply("sub", x, y))
    even = graph.apply("sub", both, graph.apply("mul", graph.constant(factor), x))
    root = graph.apply("sin", graph.apply("add", y, graph.apply("mul", graph.constant(0.3), even)))
    assert told(graph, 0.3, root) == [expected]


@pytest.mark.parametrize(("noise", "expected"), [(0.7, "but for rounding"), (0.8, None)])
def test_what_makes_up_for_rounding_is_zero_whether_a_number_is_missing_or_not(noise, expected):
    graph = Graph(halves=False)
    p, q, z = (graph.input(name) for name in "pqz")
    missing = graph.apply("isnan", z)
    size = graph.apply("add", p, graph.constant(0.7))
    inverse = graph.apply("div", graph.constant(1.0), size)
    gain = graph.choose(missing, inverse, graph.constant(0.0))
    K = [graph.apply("mul", one, gain) for one in (p, q)]
    left = [
        graph.apply(
            "sub",
            graph.apply("sub", own, graph.apply("mul", k, p)),
            graph.apply("mul", graph.constant(noise), k),
        )
        for own, k in zip((p, q), K, strict=True)
    ]
    mirrored = [graph.apply("mul", left[i], K[1 - i]) for i in (0, 1)]
    half = graph.apply("mul", graph.apply("add", *mirrored), graph.constant(0.5))
    assert told(graph, 0.5, graph.apply("sub", q, half)) == [expected]


def guarded(graph, limit, *, rounded=True):
    """The arc sine of a number, or none, where the number is beyond a limit."""
    x = graph.input("x")
    x = graph.apply("mul", x, graph.input("y")) if rounded else x
    exists = graph.apply("lt", graph.apply("abs", x), graph.constant(limit))
    angle = graph.apply("asin", graph.choose(exists, graph.constant(0.0), x))
    seen = graph.choose(exists, graph.constant(np.nan), angle)
    return graph.choose(graph.apply("isnan", seen), seen, graph.constant(7.0))


def test_beyond_a_limit_a_function_may_have_no_value_either():
    for limit, rounded, expected in (
        (1.0, True, "but for rounding"),
        (1.25, True, "but for rounding"),
        (0.75, True, None),  # there it has a value
        (1.0, False, None),  # an input may be the limit itself
    ):
        graph = Graph()
        assert told(graph, limit, guarded(graph, limit, rounded=rounded)) == [expected]


@pytest.mark.parametrize(("limit", "expected"), [(1.0, "same"), (3.0, None)])
def test_what_a_later_limit_holds_back(limit, expected):
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    counts = graph.apply("gt", x, y)
    scale = graph.choose(counts, graph.constant(1.25), graph.constant(0.5))
    size = graph.apply("add", scale, graph.choose(counts, graph.constant(0.0), x))
    weight = graph.apply("div", graph.constant(2.5), size)
    root = graph.apply("mul", y, graph.apply("min", weight, graph.constant(limit)))
    assert told(graph, 1.25, root) == [expected]


def test_a_decision_between_equal_numbers_may_be_any():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    far = graph.apply("gt", x, graph.constant(4.5))
    ends = graph.apply("sub", graph.apply("add", x, y), x)
    root = graph.choose(far, ends, y)
    assert told(graph, 4.5, root) == ["but for rounding"]
    assert told(graph, 4.5, graph.choose(far, graph.apply("sin", y), y)) == [None]


def test_nothing_is_proven_of_a_change_that_shows():
    """Random formulas: where it is proven that a change moves nothing, it moves nothing."""
    draw, proven = np.random.default_rng(7), 0
    for _ in range(150):
        graph = Graph(halves=False)
        nodes = [graph.input(name) for name in "xyz"]
        nodes.append(graph.apply("mul", nodes[0], graph.constant(1.25)))
        truths = [graph.apply("lt", nodes[1], nodes[2])]
        for _ in range(16):
            a, b = (int(k) for k in draw.choice(nodes[-6:], 2))
            if draw.random() < 0.4:
                truths.append(graph.apply("lt", a, b))
            elif draw.random() < 0.3:
                nodes.append(graph.choose(int(draw.choice(truths)), a, b))
            else:
                nodes.append(graph.apply(str(draw.choice(["add", "sub", "mul", "min"])), a, b))
        step = step_of(graph, nodes[-1])
        specialised = Specialised(step)
        given = {k: draw.normal(size=200) for k in step.order if graph.nodes[k].op == "input"}
        known = step.all_values(given)
        for one in step.mutants:
            way = step.ways.way(one)
            found = None if way is None else specialised.tells(one, way)
            if found is not None:
                proven += 1
                (after,) = step.results(known, [one])
                limit = 0.0 if found == "same" else 1e-12
                assert np.abs(after - known[step.roots[0]]).max() <= limit
    assert proven > 10
