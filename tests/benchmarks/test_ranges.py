"""What numbers can be, and what only rounding decides, in graphs small enough to tell by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.ranges import Ranges
from benchmarks.unsteady import Unsteady
from tuner.code.graph import Graph
from tuner.code.mutants import Mutant, mutants_of
from tuner.code.needed import Way, Ways
from tuner.code.operations import COMPARE


def summed(graph, parts):
    found = parts[0]
    for part in parts[1:]:
        found = graph.apply("add", found, part)
    return found


def pitch(graph):
    """The sine of a quaternion's pitch, whose length may be any."""
    a, b, c, d = (graph.input(name) for name in "abcd")
    turned = graph.apply("sub", graph.apply("mul", a, c), graph.apply("mul", b, d))
    square = summed(graph, [graph.apply("mul", x, x) for x in (a, b, c, d)])
    return graph.apply("div", graph.apply("mul", graph.constant(2.0), turned), square)


def entry(graph):
    """An entry of a vector over its length."""
    x, y, z = (graph.input(name) for name in "xyz")
    square = summed(graph, [graph.apply("mul", one, one) for one in (x, y, z)])
    return graph.apply("div", z, graph.apply("sqrt", square))


@pytest.mark.parametrize("made", [pitch, entry])
def test_quotients_have_ends(made):
    graph = Graph()
    x = made(graph)
    assert np.allclose(Ranges(graph).of(x), (-1, 1), rtol=0, atol=1e-14)
    held = graph.apply("max", x, graph.constant(-0.5))
    assert np.allclose(Ranges(graph).of(held), (-0.5, 1), rtol=0, atol=1e-14)


def test_what_is_not_bounded_has_no_ends():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    squares = [graph.apply("mul", one, one) for one in (x, y)]
    apart = graph.apply("sub", *squares)
    for under in (squares[0], apart, graph.apply("add", squares[0], graph.constant(1.0))):
        quotient = graph.apply("div", graph.apply("mul", x, y), under)
        assert Ranges(graph).of(quotient) == (-np.inf, np.inf)


def always(graph, root, value, precision="double"):
    """Whether only rounding decides of a constant of a graph with one result."""
    order = graph.reached([root])
    nodes = graph.nodes
    pairs = [nodes[k].args for k in order if nodes[k].op in COMPARE]
    program = SimpleNamespace(precision=precision)
    step = SimpleNamespace(graph=graph, order=order, program=program, decisions=pairs)
    ways, unsteady = Ways(graph, order, [root]), Unsteady(step)
    return [
        unsteady.always(one, ways.way(one))
        for one in mutants_of(graph, order)
        if nodes[nodes[one.node].args[one.at]].value == value
    ]


def test_a_limit_as_good_as_the_end_is_passed_by_rounding_alone():
    for limit, expected in ((-1 + 1e-15, True), (-1 + 1e-9, False)):
        graph = Graph()
        below = graph.apply("lt", entry(graph), graph.constant(limit))
        root = graph.choose(below, graph.input("u"), graph.constant(3.5))
        assert always(graph, root, limit) == [expected]
        assert always(graph, root, 3.5) == [expected]


def test_what_is_held_back_within_rounding_is_not_compared():
    limit = -1 + 1e-15
    graph = Graph()
    x = pitch(graph)
    held = graph.apply("max", x, graph.constant(limit))
    assert not any(always(graph, graph.apply("sin", held), limit))
    same = graph.apply("eq", x, held)
    root = graph.choose(same, graph.input("u"), graph.apply("sin", held))
    assert all(always(graph, root, limit))
    at_end = graph.apply("eq", held, graph.constant(limit))
    assert all(always(graph, graph.choose(at_end, x, graph.constant(2.5)), 2.5))


def test_what_is_left_of_a_number_has_its_rounding():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    left = graph.apply("sub", x, graph.apply("mul", y, y))
    for share, expected in ((3e-15, True), (3e-12, False)):
        limit = graph.apply("mul", x, graph.constant(share))
        root = graph.choose(graph.apply("gt", left, limit), x, y)
        assert always(graph, root, share) == [expected]
    other = graph.apply("mul", y, graph.constant(3e-15))
    root = graph.choose(graph.apply("gt", left, other), x, y)
    assert always(graph, root, 3e-15) == [False]
    assert not Unsteady(
        SimpleNamespace(
            graph=graph,
            order=graph.reached([root]),
            program=SimpleNamespace(precision="double"),
            decisions=[],
        )
    ).always(Mutant(left, 0), Way(frozenset(), frozenset()))
