"""Sums in the order in which their terms are ready.

In a recursion a sample waits for the one before it, and within a sample one operation for another:
a processor that multiplies twice in a cycle spends most cycles waiting. Of a sum the terms that are
ready first are added first, so that the last one waits for nothing but itself.
"""

from collections import Counter
from collections.abc import Iterable
from heapq import heapify, heappop, heappush
from typing import NamedTuple

from tuner.code.graph import Graph
from tuner.native.cycles import (
    ADD,
    BOTH,
    LOADED,
    MULTIPLY,
    Recursion,
    Times,
    carried_over,
    cycles,
    factors,
    is_sum,
)
from tuner.native.rewriting import Rewriter

_SIGNS = {"add": (False, False), "sub": (False, True), "neg": (True,)}
"""Which operands are subtracted."""


def earliest(
    graph: Graph, carried: Recursion, roots: Iterable[int]
) -> tuple[Graph, dict[int, int]]:
    """The same calculation but for rounding, its sums in order; and its nodes by those before.

    Args:
        graph: of the nodes.
        carried: the numbers of the state.
        roots: all nodes that are needed besides.

    >>> graph = Graph()
    >>> x, a, b, c = (graph.input((group, k)) for k, group in enumerate("suuu"))
    >>> after = graph.apply("add", graph.apply("add", graph.apply("add", x, a), b), c)
    >>> new, known = earliest(graph, [(x, after)], [])
    >>> known[x] in new.nodes[known[after]].args
    True
    """
    writer = _Writer(graph, [*roots, *(k for pair in carried for k in pair)])
    return writer.written(carried_over(carried, writer.times))


class _Term(NamedTuple):
    """A part of a sum: when it is ready, its node, whether it is subtracted.

    Attributes:
        product: whether it is multiplied as it is added; its factors are ready then.
    """

    ready: int
    node: int
    minus: bool
    product: bool


class _Writer:
    def __init__(self, graph: Graph, roots: list[int]) -> None:
        self.old, self.order = graph, graph.reached(roots)
        nodes = graph.nodes
        uses = Counter(roots) + Counter(part for k in self.order for part in nodes[k].args)
        sums = [k for k in self.order if is_sum(graph, k)]
        parts = {part for k in sums for part in nodes[k].args}
        self._inner = {k for k in parts.intersection(sums) if uses[k] == 1}
        self._products = factors(graph, self.order, uses)

    def times(self, ready: Times) -> Times:
        """When each node is ready."""
        times = dict(ready)
        for k in self.order:
            if k in self._inner or k in times:
                continue
            if is_sum(self.old, k):
                times[k] = _added(self._terms(k, times, {}), None).ready
            else:
                begin = max((times[part] for part in self.old.nodes[k].args), default=LOADED)
                times[k] = begin + cycles(self.old.nodes[k].op)
        return times

    def written(self, ready: Times) -> tuple[Graph, dict[int, int]]:
        """The graph with its sums in order; a product is written just before its sum."""
        new, known, times = Graph(most=self.old.most), dict[int, int](), self.times(ready)
        plain = Rewriter(self.old, new)
        for k in self.order:
            if k in self._inner or k in self._products:
                continue
            if not is_sum(self.old, k):
                plain.write(k, known)
                continue
            for part, _ in self._leaves(k):
                plain.write(part, known)
            whole = _added(self._terms(k, times, known), new)
            known[k] = new.apply("neg", whole.node) if whole.minus else whole.node
        return new, known

    def _terms(self, k: int, times: Times, known: dict[int, int]) -> list[_Term]:
        """The terms of a sum, by their new nodes where they are known."""
        found = []
        for part, minus in self._leaves(k):
            product = part in self._products
            ready = times[part] - MULTIPLY if product else times[part]
            found.append(_Term(ready, known.get(part, part), minus, product))
        return found

    def _leaves(self, k: int) -> list[tuple[int, bool]]:
        """The nodes of a sum's terms, and whether they are subtracted."""
        found, ahead = list[tuple[int, bool]](), [(k, False)]
        while ahead:
            k, minus = ahead.pop()
            node = self.old.nodes[k]
            for part, sign in zip(node.args, _SIGNS[node.op], strict=True):
                (ahead if part in self._inner else found).append((part, minus != sign))
        return found


def _added(terms: list[_Term], new: Graph | None) -> _Term:
    """A sum of terms, of which the two that are ready first are added again and again.

    Args:
        terms: of the sum.
        new: the graph that it is written into; None: it is none.
    """
    heapify(terms)
    while len(terms) > 1:
        one, other = heappop(terms), heappop(terms)
        begin = other.ready
        if one.product and other.product:
            begin = max(begin, one.ready + MULTIPLY)
        done = begin + (BOTH if one.product or other.product else ADD)
        node = one.node if new is None else _sum(one, other, new)
        heappush(terms, _Term(done, node, one.minus and other.minus, product=False))
    return terms[0]


def _sum(one: _Term, other: _Term, new: Graph) -> int:
    """The node of a sum of two terms; of two that are subtracted, the one to subtract."""
    if one.minus == other.minus:
        return new.apply("add", one.node, other.node)
    plus, minus = (other, one) if one.minus else (one, other)
    return new.apply("sub", plus.node, minus.node)
