"""A graph that is written again has few divisions, and the same values."""

import numpy as np
import pytest

from tuner.code.by_numpy import InNumPy
from tuner.code.graph import Graph
from tuner.native.rewriting import Rewriter

COUNT = 200


def written(old, roots):
    """The roots in another graph."""
    new, known = Graph(), {}
    writer = Rewriter(old, new)
    for k in old.reached(roots):
        writer.write(k, known)
    return new, [known[root] for root in roots]


def operations(graph, roots, *names):
    """The number of some operations that the roots take."""
    return sum(graph.nodes[k].op in names for k in graph.reached(roots))


def values(graph, roots, seed=0):
    """The roots where inputs are random numbers; a third of them is missing."""
    order = graph.reached(roots)
    draw, given = np.random.default_rng(seed), {}
    numbers = {name: draw.normal(size=COUNT) for name in ("a", "b", "c", "S")}
    numbers["missing"] = draw.random(COUNT) < 1 / 3
    numbers["S"] = numbers["S"] ** 2 + 0.1
    for k in order:
        if graph.nodes[k].op == "input":
            given[k] = numbers[graph.nodes[k].value]
    found = InNumPy(graph, order, roots).values(given)
    return [np.broadcast_to(found[root], COUNT) for root in roots]


def update(graph, case):
    """Gains, and what an update takes from a covariance, by a root as in square-root filters."""
    a, b, S = (graph.input(name) for name in ("a", "b", "S"))
    one, zero = graph.constant(1.0), graph.constant(0.0)
    inverse = graph.apply("div", one, S)
    root = graph.apply("div", one, graph.apply("sqrt", S))
    if case != "always":
        missing = graph.input("missing", "truth")
        sides = (lambda x: (x, zero)) if case == "missing" else (lambda x: (zero, x))
        inverse, root = (graph.choose(missing, *sides(x)) for x in (inverse, root))
    first, second = graph.apply("mul", a, root), graph.apply("mul", b, root)
    gain = graph.apply("mul", a, inverse)
    return [gain, graph.apply("mul", first, second), graph.apply("mul", second, second)]


@pytest.mark.parametrize("case", ["always", "missing", "seen"])
def test_an_update_inverts_one_number_and_takes_no_root(case):
    old = Graph()
    roots = update(old, case)
    new, found = written(old, roots)
    assert operations(old, roots, "div", "sqrt") == 3
    assert operations(new, found, "div", "sqrt") == 1
    for one, other in zip(values(old, roots), values(new, found), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)


def test_a_root_that_is_used_by_itself_stays():
    old = Graph()
    a, S = old.input("a"), old.input("S")
    root = old.apply("div", old.constant(1.0), old.apply("sqrt", S))
    roots = [old.apply("mul", a, root)]
    new, found = written(old, roots)
    assert operations(new, found, "sqrt") == 1
    np.testing.assert_allclose(values(old, roots), values(new, found), rtol=1e-15)


def test_what_is_chosen_is_not_inverted_again():
    """As a likelihood's variance, which is 1 where a sample is missing."""
    old = Graph()
    a, b, S, missing = *(old.input(name) for name in ("a", "b", "S")), old.input("missing", "truth")
    one = old.constant(1.0)
    inverse = old.apply("div", one, S)
    variance = old.choose(missing, S, one)
    again = old.choose(missing, variance, old.constant(4.0))
    roots = [old.apply("mul", a, inverse)]
    roots += [old.apply("div", b, variance), old.apply("div", a, again)]
    new, found = written(old, roots)
    assert operations(new, found, "div") == 1
    for one, other in zip(values(old, roots), values(new, found), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-15)


def test_a_quotient_by_what_nothing_else_is_divided_by_stays_one():
    old = Graph()
    a, S, missing = old.input("a"), old.input("S"), old.input("missing", "truth")
    roots = [old.apply("div", a, old.choose(missing, S, old.constant(1.0)))]
    new, found = written(old, roots)
    assert operations(new, found, "div") == 1
    np.testing.assert_array_equal(values(old, roots), values(new, found))


@pytest.mark.parametrize("turned", [False, True])
def test_a_product_of_three_takes_what_is_known_of_two(turned):
    """What an update takes from a covariance, w w' / S, is w times the gain."""
    old = Graph()
    a, b, S = (old.input(name) for name in ("a", "b", "S"))
    inverse = old.apply("div", old.constant(1.0), S)
    gains = [old.apply("mul", w, inverse) for w in (a, b)]
    pairs = [old.apply("mul", *two) for two in ((a, a), (a, b), (b, b))]
    taken = [old.apply("mul", *((inverse, w) if turned else (w, inverse))) for w in pairs]
    new, found = written(old, [*gains, *taken])
    assert operations(old, [*gains, *taken], "mul") == 8
    assert operations(new, found, "mul") == 5
    for one, other in zip(values(old, [*gains, *taken]), values(new, found), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-15)


@pytest.mark.parametrize("op", ["add", "sub"])
def test_two_choices_that_are_zero_in_turn_are_one(op):
    """As a derivative of a size, which is chosen by a sign."""
    old = Graph()
    a, b, missing = old.input("a"), old.input("b"), old.input("missing", "truth")
    zero = old.constant(0.0)
    roots = [old.apply(op, old.choose(missing, a, zero), old.choose(missing, zero, b))]
    new, found = written(old, roots)
    assert operations(new, found, "choose") == 1
    assert operations(new, found, "add", "sub") == 0
    np.testing.assert_array_equal(values(old, roots), values(new, found))


def test_choices_that_are_not_zero_in_turn_stay():
    old = Graph()
    a, b, missing = old.input("a"), old.input("b"), old.input("missing", "truth")
    roots = [old.apply("add", old.choose(missing, a, b), old.choose(missing, b, old.constant(0.0)))]
    new, found = written(old, roots)
    assert operations(new, found, "choose") == 2
    np.testing.assert_array_equal(values(old, roots), values(new, found))


@pytest.mark.parametrize("first", [False, True])
def test_a_number_or_its_negative_is_a_product(first):
    """So that nothing waits for the choice but the factor."""
    old = Graph()
    a, missing = old.input("a"), old.input("missing", "truth")
    pair = old.apply("neg", a), a
    roots = [old.choose(missing, *(pair if first else pair[::-1]))]
    new, (found,) = written(old, roots)
    assert new.nodes[found].op == "mul"
    np.testing.assert_array_equal(values(old, roots), values(new, [found]))
