"""How large and how small numbers of a step can be, whatever its state and its sample are."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import TypeAlias

import numpy as np

from tuner.code.graph import Graph

Range: TypeAlias = tuple[float, float]
_ALL: Range = (-np.inf, np.inf)
_Terms: TypeAlias = Mapping[tuple[int, ...], float]
"""A polynomial: the coefficient of each product of nodes."""


class Ranges:
    """The ranges of the nodes of a graph, without rounding.

    An entry of a vector over its length is at most one. In general the quotient of two quadratic
    forms, of which the lower one is positive, lies between the least and the largest eigenvalue of
    both matrices together.

    Args:
        graph: the nodes.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self.of: Callable[[int], Range] = cache(self._of)

    def _of(self, k: int) -> Range:
        """The smallest and the largest value that a node can have."""
        node = self._graph.nodes[k]
        if node.op == "constant" and node.kind == "real":
            return float(node.value), float(node.value)
        if node.op in ("max", "min"):
            pick = max if node.op == "max" else min
            first, second = (self.of(part) for part in node.args)
            return pick(first[0], second[0]), pick(first[1], second[1])
        if node.op == "neg":
            least, most = self.of(node.args[0])
            return -most, -least
        return self._quotient(*node.args) if node.op == "div" and node.kind == "real" else _ALL

    def _quotient(self, over: int, under: int) -> Range:
        root = self._graph.nodes[under]
        if root.op == "sqrt":  # the square of this quotient is one of sums of products
            first = self._terms(over)
            if any(len(part) != 1 for part in first):
                return _ALL
            least, most = _bounds(_product(first, first), self._terms(root.args[0]))
            size = float(np.sqrt(max(-least, most)))
            return -size, size
        return _bounds(self._terms(over), self._terms(under))

    def _terms(self, k: int) -> _Terms:
        """A node as sums of products of at most two others."""
        node = self._graph.nodes[k]
        if node.op == "constant":
            return {(): float(node.value)}
        if node.op == "neg":
            return _product({(): -1.0}, self._terms(node.args[0]))
        if node.op in ("add", "sub", "mul"):
            first, second = (self._terms(part) for part in node.args)
            if node.op == "mul":
                degree = sum(max(map(len, part), default=0) for part in (first, second))
                return _product(first, second) if degree <= 2 else {(k,): 1.0}
            return _sum(first, second, 1.0 if node.op == "add" else -1.0)
        return {(k,): 1.0}


def _sum(first: _Terms, second: _Terms, sign: float) -> _Terms:
    found = dict(first)
    for part, factor in second.items():
        found[part] = found.get(part, 0.0) + sign * factor
    return found


def _product(first: _Terms, second: _Terms) -> _Terms:
    found = dict[tuple[int, ...], float]()
    for one, factor in first.items():
        for other, more in second.items():
            part = tuple(sorted(one + other))
            found[part] = found.get(part, 0.0) + factor * more
    return found


def _bounds(over: _Terms, under: _Terms) -> Range:
    """The least and the largest quotient of two quadratic forms, of which one is positive."""
    if any(len(part) != 2 for part in (*over, *under)):
        return _ALL
    places = {k: at for at, k in enumerate(sorted({k for part in under for k in part}))}
    if any(k not in places for part in over for k in part):
        return _ALL
    A, B = np.zeros((2, len(places), len(places)))
    for matrix, terms in ((A, over), (B, under)):
        for (one, other), factor in terms.items():
            matrix[places[one], places[other]] += factor / 2
            matrix[places[other], places[one]] += factor / 2
    sizes, turn = np.linalg.eigh(B)
    if not sizes.size or sizes[0] <= 0:
        return _ALL
    narrow = turn / np.sqrt(sizes)
    found = np.linalg.eigvalsh(narrow.T @ A @ narrow)
    return float(found[0]), float(found[-1])
