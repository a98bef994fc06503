"""What follows from decisions of a step, and which exclude each other."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from tuner.code.graph import Graph
from tuner.code.nodes import Node
from tuner.code.operations import COMPARE, in_numpy

Decided: TypeAlias = frozenset[tuple[int, bool]]
"""Truth values, and what they are."""
NOTHING: Decided = frozenset()


class Facts:
    """What follows from truth values.

    Args:
        graph: of a step.
        users: the operations that use each node.
    """

    def __init__(self, graph: Graph, users: Mapping[int, Sequence[int]]) -> None:
        self._graph, self._users = graph, users
        self._facts: dict[tuple[int, bool], Decided | None] = {}

    def joined(self, way: Decided, k: int, value: bool) -> Decided | None:
        """One decision more; None: it contradicts another one."""
        more = self._fact(k, value)
        if more is None or any((j, not truth) in way for j, truth in more):
            return None
        return way | more

    def _fact(self, k: int, value: bool) -> Decided | None:
        """What follows from a truth value, itself included; None: it is never so."""
        if (k, value) not in self._facts:
            self._facts[k, value] = self._worked_out(k, value)
        return self._facts[k, value]

    def _worked_out(self, k: int, value: bool) -> Decided | None:
        node = self._graph.nodes[k]
        if node.op == "constant":
            return NOTHING if bool(node.value) == value else None
        if node.op in ("eq", "ne") and value == (node.op == "eq") and self._one_is_infinite(node):
            return None
        found: Decided | None = frozenset({(k, value)})
        for part, truth in self._implied(k, value):
            found = self.joined(found or NOTHING, part, truth)
            if found is None:
                return None
        follow = {"not": True, "and": value, "or": not value}.get(node.op, False)
        for part in node.args if follow else ():
            found = self.joined(found or NOTHING, part, value != (node.op == "not"))
            if found is None:
                break
        return found

    def _one_is_infinite(self, compared: Node) -> bool:
        """Whether a number that is finite, or missing, is compared with an infinite one."""
        pairs = zip(compared.args, compared.args[::-1], strict=True)
        ends = (np.inf, -np.inf)
        return any(
            self._is_given(x) and any(self._graph.is_constant(y, end) for end in ends)
            for x, y in pairs
        )

    def _is_given(self, k: int) -> bool:
        """Whether a number is one of the state or of a sample, which are finite, or missing."""
        node = self._graph.nodes[k]
        if node.op == "choose":
            return all(self._is_given(part) for part in node.args[1:])
        if node.op == "constant":
            return node.kind == "real" and not np.isinf(node.value)
        return node.op == "input"

    def _implied(self, k: int, value: bool) -> Iterator[tuple[int, bool]]:
        """Truth values that follow from the outcome of a comparison."""
        nodes, node = self._graph.nodes, self._graph.nodes[k]
        if node.op in ("gt", "lt") and value:
            for other in self._users.get(node.args[0], ()):
                if nodes[other].op in ("eq", "ne") and set(nodes[other].args) == set(node.args):
                    yield other, nodes[other].op == "ne"
        if node.op not in (*COMPARE, "isnan"):
            return
        for at, part in enumerate(node.args):
            rest = [nodes[other] for other in (*node.args[:at], *node.args[at + 1 :])]
            if nodes[part].op != "choose" or any(one.op != "constant" for one in rest):
                continue
            for side in (1, 2):  # what is chosen is not what would decide otherwise
                chosen = nodes[nodes[part].args[side]]
                values = [one.value for one in rest]
                values.insert(at, chosen.value)
                if chosen.op == "constant" and bool(in_numpy(node.op, *values)) != value:
                    yield nodes[part].args[0], side == 2

    def closed(self, way: Decided) -> Decided | None:
        """With what follows where one of two operands is known; None: it contradicts another."""
        nodes, found, before = self._graph.nodes, way, None
        while found != before:
            before = found
            for k, value in sorted(before):
                if nodes[k].op not in ("and", "or") or value != (nodes[k].op == "or"):
                    continue
                for part, other in zip(nodes[k].args, nodes[k].args[::-1], strict=True):
                    if (part, not value) in found:
                        more = self.joined(found, other, value)
                        if more is None:
                            return None
                        found = more
        return found
