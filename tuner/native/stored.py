"""The numbers that a pass over a record stores for the pass back, which computes the rest again."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from tuner.code.expression import CALLS
from tuner.code.graph import Graph

_STORED, _SLOW = 4, 20
"""Operations that take as long as to store and load a number, and as a quotient or a call."""
_NEVER = 10**8
"""What no choice may cost."""


class _Edge(NamedTuple):
    begin: int
    end: int
    cost: int


def cheapest(graph: Graph, needed: Iterable[int], free: set[int]) -> list[int]:
    """The nodes to store, so that to store them and to compute the needed ones takes least.

    It is a minimum cut: a number is available if it is stored, or if it is computed again from
    available ones. Its edge from one to the other side is cut in the first case; in the second that
    which bears its cost, and the numbers it is computed from are on the far side as well.

    Args:
        graph: of the nodes.
        needed: in the pass back.
        free: nodes that are available at no cost; other inputs can only be stored.

    >>> graph = Graph()
    >>> state = [graph.input(("s", k)) for k in range(2)]
    >>> total = graph.apply("add", *state)
    >>> root = graph.apply("sqrt", total)
    >>> cheapest(graph, [total], set()) == [total]
    True
    >>> cheapest(graph, [*state, total, root], set()) == [*state, root]
    True
    """
    order = [k for k in graph.reached(needed) if k not in free]
    at = {k: place for place, k in enumerate(order)}
    source, sink = 2 * len(order), 2 * len(order) + 1
    edges = np.array([*_edges(graph, at, set(needed), source, sink)], np.int32).reshape(-1, 3)
    shape = sink + 1, sink + 1
    room = csr_array((edges[:, 2], (edges[:, 0], edges[:, 1])), shape=shape)
    left = room - maximum_flow(room, source, sink).flow
    left.eliminate_zeros()
    near = np.zeros(sink + 1, bool)
    near[breadth_first_order(left, source, return_predecessors=False)] = True
    pairs = near[:source].reshape(-1, 2)
    return [k for k, (computed, had) in zip(order, pairs, strict=True) if computed and not had]


def _edges(
    graph: Graph, at: dict[int, int], needed: set[int], source: int, sink: int
) -> Iterator[_Edge]:
    """The edges of the cut; a number has a node from which it is computed, and one that has it."""
    for k, place in at.items():
        computed, had = 2 * place, 2 * place + 1
        yield _Edge(source, computed, _cost(graph.nodes[k].op))
        yield _Edge(computed, had, _STORED)
        yield from (_Edge(2 * at[part] + 1, computed, _NEVER) for part in _parts(graph, k, at))
        if k in needed:
            yield _Edge(had, sink, _NEVER)


def _parts(graph: Graph, k: int, at: dict[int, int]) -> Sequence[int]:
    return [part for part in dict.fromkeys(graph.nodes[k].args) if part in at]


def _cost(op: str) -> int:
    if op == "input":
        return _NEVER
    return _SLOW if op in {"div", *CALLS} else 1
