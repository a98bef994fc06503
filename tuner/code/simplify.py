"""Shorter forms of an operation: exact ones, but for the sign of a zero and one rounding.

A factor that is zero once and for all takes its product with it, whatever the other one will be.
"""

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from tuner.code.nodes import Nodes
from tuner.code.operations import COMPARE

Shorter: TypeAlias = Callable[[Nodes, int, int], int | None]


def simpler(graph: Nodes, op: str, entries: tuple[int, ...]) -> int | None:
    """A simpler node that equals an operation; None without one."""
    if len(entries) == 1:
        return _of_one(graph, op, entries[0])
    x, y = entries
    for rule in _RULES.get(op, ()):
        found = rule(graph, x, y)
        if found is not None:
            return found
    if op in COMPARE:
        return _compared(graph, op, x, y)
    return None


def _of_one(graph: Nodes, op: str, x: int) -> int | None:
    inner = graph.nodes[x]
    if op in ("neg", "not") and inner.op == op:
        return inner.args[0]
    if op == "neg" and inner.op == "sub":
        return graph.apply("sub", *reversed(inner.args))
    if op in ("isnan", "is_finite", "abs", "cos") and inner.op == "neg":
        return graph.apply(op, inner.args[0])
    if op in ("isnan", "is_finite") and inner.kind == "whole":
        return graph.constant(op == "is_finite")
    if op in ("floor", "ceil", "round") and inner.kind == "whole":
        return x
    return None


def _compared(graph: Nodes, op: str, x: int, y: int) -> int | None:
    """One of two constants that is compared with a third is a truth value."""
    if x == y and graph.nodes[x].kind == "real":
        return graph.apply("isnan", x) if op == "ne" else None
    for inside, other, turned in ((x, y, False), (y, x, True)):
        condition, *chosen = graph.nodes[inside].args or (inside,)
        if graph.nodes[inside].op == "convert" and graph.nodes[condition].kind == "truth":
            chosen = [graph.constant(1), graph.constant(0)]
        elif graph.nodes[inside].op != "choose":
            continue
        if all(map(graph.is_constant, (*chosen, other))):
            pairs = [(one, other) for one in chosen]
            true, false = (graph.apply(op, *(p[::-1] if turned else p)) for p in pairs)
            return graph.choose(condition, false, true)
    return None


def _commutative(rule: Shorter) -> Shorter:
    """A rule for commutative operations."""

    def both(graph: Nodes, x: int, y: int) -> int | None:
        found = rule(graph, x, y)
        return rule(graph, y, x) if found is None else found

    return both


@_commutative
def _add_nothing(graph: Nodes, x: int, y: int) -> int | None:
    return y if graph.is_constant(x, 0) else None


@_commutative
def _add_negative(graph: Nodes, x: int, y: int) -> int | None:
    return graph.apply("sub", y, graph.nodes[x].args[0]) if graph.nodes[x].op == "neg" else None


def _add_itself(graph: Nodes, x: int, y: int) -> int | None:
    if x != y or graph.nodes[x].kind != "real":
        return None
    return graph.apply("mul", graph.constant(graph.precision(2)), x)


def _less_nothing(graph: Nodes, x: int, y: int) -> int | None:
    return x if graph.is_constant(y, 0) else None


def _nothing_less(graph: Nodes, x: int, y: int) -> int | None:
    return graph.apply("neg", y) if graph.is_constant(x, 0) else None


def _less_negative(graph: Nodes, x: int, y: int) -> int | None:
    return graph.apply("add", x, graph.nodes[y].args[0]) if graph.nodes[y].op == "neg" else None


def _negative_less(graph: Nodes, x: int, y: int) -> int | None:
    if graph.nodes[x].op != "neg":
        return None
    return graph.apply("neg", graph.apply("add", graph.nodes[x].args[0], y))


@_commutative
def _times_number(graph: Nodes, x: int, y: int) -> int | None:
    if graph.is_constant(x, 0):
        return x
    if graph.is_constant(x, 1):
        return y
    return graph.apply("neg", y) if graph.is_constant(x, -1) else None


@_commutative
def _times_twice(graph: Nodes, x: int, y: int) -> int | None:
    """Two constant factors are one: exact where one of them is a power of two."""
    if not graph.is_constant(x) or graph.nodes[y].op != "mul" or graph.nodes[y].kind != "real":
        return None
    first = float(graph.nodes[x].value)
    for number, rest in (graph.nodes[y].args, graph.nodes[y].args[::-1]):
        if graph.is_constant(number):
            second = float(graph.nodes[number].value)
            if 0.5 in (math.frexp(abs(first))[0], math.frexp(abs(second))[0]):
                return graph.apply("mul", graph.apply("mul", x, number), rest)
    return None


@_commutative
def _times_half(graph: Nodes, x: int, y: int) -> int | None:
    """The mean of a matrix and its transpose, which are equal but for rounding."""
    if not graph.halves or not graph.is_constant(x, 0.5) or graph.nodes[y].op != "add":
        return None
    one, other = graph.nodes[y].args
    if not graph.points.same(one, other):
        return None
    graph.means.add(one)
    return one


@_commutative
def _times_negative(graph: Nodes, x: int, y: int) -> int | None:
    """A sign moves outwards, where a sum absorbs it."""
    if graph.nodes[x].op != "neg":
        return None
    return graph.apply("neg", graph.apply("mul", graph.nodes[x].args[0], y))


def _nothing_over(graph: Nodes, x: int, y: int) -> int | None:
    return x if graph.is_constant(x, 0) else None


def _over_number(graph: Nodes, x: int, y: int) -> int | None:
    """A quotient as a product with the inverse, where that has full precision."""
    if not graph.is_constant(y) or graph.nodes[y].kind != "real":
        return None
    inverse = graph.apply("div", graph.constant(graph.precision(1)), y)
    value = abs(float(graph.nodes[inverse].value))
    limits = np.finfo(graph.precision)
    normal = float(limits.tiny) <= value <= float(limits.max)
    return graph.apply("mul", x, inverse) if normal else None


@_commutative
def _and_known(graph: Nodes, x: int, y: int) -> int | None:
    if graph.nodes[x].kind != "truth" or not graph.is_constant(x):
        return None
    return y if graph.nodes[x].value else x


@_commutative
def _or_known(graph: Nodes, x: int, y: int) -> int | None:
    if graph.nodes[x].kind != "truth" or not graph.is_constant(x):
        return None
    return x if graph.nodes[x].value else y


def _twice(graph: Nodes, x: int, y: int) -> int | None:
    return x if x == y else None


_RULES: Mapping[str, tuple[Shorter, ...]] = {
    "add": (_add_nothing, _add_negative, _add_itself),
    "sub": (_less_nothing, _nothing_less, _less_negative, _negative_less),
    "mul": (_times_number, _times_twice, _times_half, _times_negative),
    "div": (_nothing_over, _over_number),
    "and": (_and_known, _twice),
    "or": (_or_known, _twice),
    "max": (_twice,),
    "min": (_twice,),
}
