"""What has to be decided for a constant to show: in graphs small enough to tell by hand."""

import numpy as np

from tuner.code.graph import Graph
from tuner.code.mutants import Mutant
from tuner.code.needed import Ways


def way(graph, root, value):
    """The way from a constant of a graph with one result."""
    order = graph.reached([root])
    (one,) = (
        Mutant(k, at)
        for k in order
        for at, part in enumerate(graph.nodes[k].args)
        if graph.is_constant(part, value)
    )
    return Ways(graph, order, [root]).way(one)


def test_what_is_chosen_has_to_be_chosen():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    first, second = graph.apply("lt", x, y), graph.apply("isnan", y)
    inner = graph.choose(second, x, graph.apply("mul", y, graph.constant(3.5)))
    found = way(graph, graph.choose(first, inner, x), 3.5)
    assert found.needed == {(first, False), (second, True)}
    assert not found.turned


def test_both_of_two_conditions_are_needed():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    first, second = graph.apply("lt", x, y), graph.apply("isnan", y)
    both = graph.apply("and", first, second)
    found = way(graph, graph.choose(both, x, graph.constant(3.5)), 3.5)
    assert found.needed == {(both, True), (first, True), (second, True)}


def test_what_replaces_a_missing_number_reaches_nothing():
    graph = Graph()
    z = graph.input("z")
    missing = graph.apply("isnan", z)
    size = graph.choose(missing, graph.apply("mul", z, z), graph.constant(3.5))
    gain = graph.apply("div", graph.input("p"), size)
    apart = graph.choose(missing, graph.apply("sub", z, graph.input("x")), graph.constant(0.0))
    assert way(graph, graph.apply("mul", gain, apart), 3.5) is None


def test_of_several_ways_the_common_decision_is_needed():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    moved = graph.apply("mul", x, graph.constant(3.5))
    one, other = graph.apply("lt", x, y), graph.apply("gt", x, graph.constant(9.0))
    part = graph.choose(one, y, graph.choose(other, y, moved))
    whole = graph.apply("add", part, graph.choose(one, x, graph.apply("sin", moved)))
    assert way(graph, whole, 3.5).needed == {(one, True)}


def test_a_limit_shows_where_it_decides():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    limit = graph.apply("mul", graph.constant(3.5), y)
    far = graph.apply("gt", x, limit)
    found = way(graph, graph.choose(far, x, y), 3.5)
    assert (found.needed, found.turned) == (frozenset(), {far})
    both = graph.apply("add", limit, graph.choose(far, x, y))
    assert way(graph, both, 3.5).turned == frozenset()


def test_a_way_is_needed_for_every_change_that_shows():
    """Random formulas: no change shows in a step in which something needed is decided otherwise."""
    draw = np.random.default_rng(4)
    for _ in range(40):
        graph = Graph(halves=False)
        nodes = [graph.input(name) for name in "xyz"]
        nodes.append(graph.apply("mul", nodes[0], graph.constant(1.25)))
        truths = [graph.apply("lt", nodes[1], nodes[2])]
        for _ in range(14):
            a, b = draw.choice(nodes[-6:], 2)
            p, q = draw.choice(truths, 2)
            if draw.random() < 0.4:
                truths.append(graph.apply("lt", int(a), int(b)))
                truths.append(graph.apply(str(draw.choice(["and", "or"])), int(p), int(q)))
            elif draw.random() < 0.5:
                zero = graph.constant(0.0) if draw.random() < 0.4 else int(b)
                nodes.append(graph.choose(int(p), int(a), zero))
            else:
                op = str(draw.choice(["add", "mul", "sub"]))
                nodes.append(graph.apply(op, int(a), int(b)))
        root = nodes[-1]
        order = graph.reached([root])
        ways = Ways(graph, order, [root])
        for k in order:
            for at, part in enumerate(graph.nodes[k].args):
                if graph.is_constant(part, 1.25):
                    _check(graph, order, root, Mutant(k, at), ways, draw)


def _check(graph, order, root, one, ways, draw):
    found = ways.way(one)
    for _ in range(20):
        given = dict(zip("xyz", draw.normal(size=3), strict=True))
        plain = _values(graph, order, given)
        changed = _values(graph, order, given, one)
        if plain[root] != changed[root]:
            assert found is not None
            assert all(plain[k] == truth for k, truth in found.needed)


def _values(graph, order, given, one=None):
    known = {}
    for k in order:
        node = graph.nodes[k]
        args = [known[part] for part in node.args]
        if one is not None and k == one.node:
            args[one.at] *= 3.0
        known[k] = _value(node, args, given)
    return known


def _value(node, args, given):
    functions = {
        "constant": lambda: node.value,
        "input": lambda: given[node.value],
        "add": lambda: args[0] + args[1],
        "sub": lambda: args[0] - args[1],
        "mul": lambda: args[0] * args[1],
        "neg": lambda: -args[0],
        "lt": lambda: bool(args[0] < args[1]),
        "and": lambda: args[0] and args[1],
        "or": lambda: args[0] or args[1],
        "not": lambda: not args[0],
        "choose": lambda: args[1] if args[0] else args[2],
    }
    return functions[node.op]()


def test_of_a_chosen_constant_that_would_decide_otherwise_the_other_is_chosen():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    counts = graph.apply("gt", x, y)
    zero = graph.constant(0.0)
    variance = graph.choose(counts, zero, graph.apply("mul", y, y))
    wrong = graph.apply("gt", variance, zero)
    size = graph.choose(counts, graph.constant(3.5), y)
    result = graph.choose(wrong, x, graph.apply("sin", size))
    assert way(graph, graph.apply("add", result, graph.apply("mul", size, zero)), 3.5) is None
    other = graph.choose(counts, y, graph.constant(2.5))
    found = way(graph, graph.choose(wrong, x, graph.apply("sin", other)), 2.5)
    assert found.needed == {(wrong, True), (counts, True)}


def test_one_of_two_is_false_where_both_are_not_true():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    zero = graph.constant(0.0)
    above, other = graph.apply("gt", x, zero), graph.apply("ne", x, zero)
    early = graph.apply("and", graph.apply("lt", y, x), above)
    fresh = graph.apply("and", early, other)
    missing = graph.apply("isnan", graph.choose(fresh, y, graph.constant(np.nan)))
    seen = graph.choose(missing, graph.constant(3.5), zero)
    assert way(graph, graph.choose(early, x, graph.apply("sin", seen)), 3.5) is None
    assert way(graph, graph.choose(early, graph.apply("sin", seen), x), 3.5) is not None


def test_a_share_of_a_number_that_it_is_compared_with_decides_nothing():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    share = graph.apply("mul", x, graph.constant(0.25))
    assert way(graph, graph.choose(graph.apply("gt", x, share), y, x), 0.25) is None
    assert way(graph, graph.choose(graph.apply("gt", y, share), y, x), 0.25) is not None
    large = graph.apply("mul", x, graph.constant(0.9995))
    assert way(graph, graph.choose(graph.apply("gt", x, large), y, x), 0.9995) is not None


def test_what_each_operation_needs_is_what_its_constants_need():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    first, second = graph.apply("lt", x, y), graph.apply("gt", x, graph.constant(9.0))
    moved = graph.apply("mul", x, graph.constant(3.5))
    part = graph.choose(first, y, graph.choose(second, y, moved))
    root = graph.apply("add", part, graph.choose(first, x, graph.apply("sin", moved)))
    order = graph.reached([root])
    found = Ways(graph, order, [root]).for_each(order)
    assert found[moved] == {(first, True)}
    assert found[second] == {(first, True)}
    assert found[first] == found[x] == found[root] == frozenset()


def test_of_several_conditions_the_others_are_needed():
    graph = Graph()
    x, y = graph.input("x"), graph.input("y")
    three = [graph.apply("lt", x, graph.constant(float(k))) for k in (1, 2)]
    three.append(graph.apply("lt", y, graph.constant(3.0)))
    both = graph.apply("and", graph.apply("and", three[0], three[1]), three[2])
    root = graph.choose(both, x, graph.apply("sin", y))
    order = graph.reached([root])
    found = Ways(graph, order, [root]).for_each(order)
    assert {(three[1], True), (three[2], True)} <= found[three[0]]
    assert {(three[0], True), (three[1], True)} <= found[three[2]]
    assert found[both] == frozenset()


def test_a_measured_number_is_not_infinite_and_a_sum_may_be():
    for computed in (False, True):
        graph = Graph()
        x, y = graph.input("x"), graph.input("y")
        z = graph.choose(graph.apply("isnan", x), x, graph.constant(0.0))
        z = graph.apply("add", z, y) if computed else z
        endless = graph.apply("eq", z, graph.constant(np.inf))
        root = graph.choose(endless, z, graph.constant(3.5))
        assert (way(graph, root, 3.5) is not None) == computed
