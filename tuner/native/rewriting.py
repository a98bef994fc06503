"""A rebuilt graph, with some nodes replaced, and few divisions."""

from collections import Counter
from collections.abc import Mapping

import numpy as np

from tuner.code.graph import Graph
from tuner.code.operations import Kind

_TYPES: Mapping[Kind, np.dtype] = {
    "real": np.dtype(float),
    "whole": np.dtype(int),
    "truth": np.dtype(bool),
}


class Rewriter:
    """A writer of a graph's nodes into another graph, with simplification.

    A number that several are divided by is inverted once.

    Args:
        old: the graph.
        new: the other one.
    """

    def __init__(self, old: Graph, new: Graph) -> None:
        self.old, self.new = old, new
        self._divided = Counter(node.args[1] for node in old.nodes if node.op == "div")

    def write(self, entry: int, known: dict[int, int]) -> None:
        """Write a node.

        Args:
            entry: the node; its operands are known.
            known: new nodes by old ones; grows.
        """
        if entry not in known:
            known[entry] = self._written(entry, known)

    def _written(self, entry: int, known: Mapping[int, int]) -> int:
        node, new = self.old.nodes[entry], self.new
        if node.op == "constant":
            return new.constant(node.value)
        if node.op == "input":
            return new.input(node.value, node.kind)
        given = [known[k] for k in node.args]
        if node.op == "choose":
            return self._chosen(*given)
        if node.op == "convert":
            return new.convert(given[0], _TYPES[node.kind])
        if node.op == "div" and node.kind == "real":
            return self._over(given[0], given[1], shared=self._divided[node.args[1]] > 1)
        return new.apply(node.op, *given)

    def _chosen(self, condition: int, yes: int, no: int) -> int:
        """One of two; a sign moves outwards, where a sum absorbs it."""
        nodes, zero = self.new.nodes, self.new.constant(0.0)
        both = [(k, nodes[k].args[0] if nodes[k].op == "neg" else k) for k in (yes, no)]
        signed = [k != plain for k, plain in both]
        if any(signed) and all(s or k == zero for s, (k, _) in zip(signed, both, strict=True)):
            chosen = self.new.choose(condition, both[1][1], both[0][1])
            return self.new.apply("neg", chosen)
        return self.new.choose(condition, no, yes)

    def _over(self, x: int, y: int, *, shared: bool) -> int:
        """A quotient; a product with the inverse, where several share it."""
        graph, node, one = self.new, self.new.nodes[y], self.new.constant(1.0)
        if node.op == "mul" and node.args[0] == node.args[1]:
            inverse = self._over(one, node.args[0], shared=False)
            return graph.apply("mul", x, graph.apply("mul", inverse, inverse))
        if node.op == "choose" and all(graph.is_constant(k) for k in node.args[1:]):
            yes, no = (graph.apply("div", one, k) for k in node.args[1:])
            return graph.apply("mul", x, graph.choose(node.args[0], no, yes))
        if shared and not graph.is_constant(y):
            return graph.apply("mul", x, graph.apply("div", one, y))
        return graph.apply("div", x, y)
