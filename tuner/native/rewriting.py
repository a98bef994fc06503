"""A rebuilt graph, with some nodes replaced, and few divisions."""

from collections import Counter
from collections.abc import Callable, Mapping

import numpy as np

from tuner.code.graph import Graph
from tuner.code.nodes import Node
from tuner.code.operations import Kind

_TYPES: Mapping[Kind, np.dtype] = {
    "real": np.dtype(float),
    "whole": np.dtype(int),
    "truth": np.dtype(bool),
}


class Rewriter:
    """A writer of a graph's nodes into another graph, with simplification.

    A number that several are divided by is inverted once, and no root is taken of what is squared
    again: of an update of a Kalman filter, with one measurement, the variance is inverted, no more.

    Args:
        old: the graph.
        new: the other one.
    """

    def __init__(self, old: Graph, new: Graph) -> None:
        self.old, self.new = old, new
        self._inverted = dict[int, int]()
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
        return self._operation(node, [known[k] for k in node.args])

    def _operation(self, node: Node, given: list[int]) -> int:
        if node.op == "choose":
            return self._chosen(*given)
        if node.op == "convert":
            return self.new.convert(given[0], _TYPES[node.kind])
        if node.op == "div" and node.kind == "real":
            return self._over(*given, shared=self._divided[node.args[1]] > 1)
        if node.op == "mul" and node.kind == "real":
            return self._product(*given)
        if node.op in ("add", "sub") and node.kind == "real":
            return self._sum(node.op, *given)
        return self.new.apply(node.op, *given)

    def _sum(self, op: str, x: int, y: int) -> int:
        """A sum; of two choices by one condition, which are zero in turn, it is one choice."""
        one, other = self.new.nodes[x], self.new.nodes[y]
        if one.op == other.op == "choose" and one.args[0] == other.args[0]:
            pairs = list(zip(one.args[1:], other.args[1:], strict=True))
            if all(any(self.new.is_constant(k, 0.0) for k in pair) for pair in pairs):
                yes, no = (self.new.apply(op, *pair) for pair in pairs)
                return self._chosen(one.args[0], yes, no)
        return self.new.apply(op, x, y)

    def _product(self, x: int, y: int) -> int:
        """A product; of two numbers over one root, of one over the square with the other."""
        nodes = self.new.nodes
        if nodes[x].op == nodes[y].op == "mul":
            for factor in nodes[x].args:
                square = self._square(factor) if factor in nodes[y].args else None
                if square is not None:
                    one, other = (_without(factor, nodes[k].args) for k in (x, y))
                    return self.new.apply("mul", self.new.apply("mul", one, square), other)
        found = self._of_known(x, y)
        return self.new.apply("mul", x, y) if found is None else found

    def _of_known(self, x: int, y: int) -> int | None:
        """A product of three numbers, of which two others are multiplied already.

        Of w w' / S it is K w', where the gain K = w / S has been computed.
        """
        for pair, third in ((x, y), (y, x)):
            node = self.new.nodes[pair]
            for factor in node.args if node.op == "mul" else ():
                known = self.new.found("mul", factor, third)
                if known is not None:
                    return self.new.apply("mul", known, _without(factor, node.args))
        return None

    def _square(self, entry: int) -> int | None:
        """The square of what is an inverse root, or zero where something is missing."""
        graph, node = self.new, self.new.nodes[entry]
        if graph.is_constant(entry, 0.0):
            return entry
        if node.op == "choose":
            return self._of_both(node, self._square)
        if node.op == "div" and graph.is_constant(node.args[0], 1.0):
            root = graph.nodes[node.args[1]]
            if root.op == "sqrt":
                return self._inverse(root.args[0])
        return None

    def _inverse(self, y: int) -> int:
        if y not in self._inverted:
            self._inverted[y] = self.new.apply("div", self.new.constant(1.0), y)
        return self._inverted[y]

    def _known_inverse(self, y: int) -> int | None:
        """An inverse that takes no division; None: there is none."""
        graph, node = self.new, self.new.nodes[y]
        if graph.is_constant(y):
            return self._inverse(y)
        if node.op == "choose":
            return self._of_both(node, self._known_inverse)
        return self._inverted.get(y)

    def _of_both(self, node: Node, what: Callable[[int], int | None]) -> int | None:
        """A choice between what there is of each of two; None: there is none of one."""
        condition, yes, no = node.args
        first, second = what(yes), what(no)
        if first is None or second is None:
            return None
        return self.new.choose(condition, second, first)

    def _chosen(self, condition: int, yes: int, no: int) -> int:
        """One of two; a sign moves outwards, where a sum absorbs it, and one of two is a factor."""
        nodes, zero = self.new.nodes, self.new.constant(0.0)
        for one, other, sign in ((yes, no, -1.0), (no, yes, 1.0)):
            if nodes[one].op == "neg" and nodes[one].args[0] == other:
                chosen = self.new.choose(
                    condition, self.new.constant(-sign), self.new.constant(sign)
                )
                return self.new.apply("mul", other, chosen)
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
            root = self._over(one, node.args[0], shared=False)
            return graph.apply("mul", x, graph.apply("mul", root, root))
        inverse = self._known_inverse(y) if node.op == "choose" else None
        if inverse is not None:
            return graph.apply("mul", x, inverse)
        if (shared and not graph.is_constant(y)) or y in self._inverted:
            return graph.apply("mul", x, self._inverse(y))
        found = graph.apply("div", x, y)
        if x == one:
            self._inverted[y] = found
        return found


def _without(factor: int, factors: tuple[int, ...]) -> int:
    """The other one of two factors."""
    return factors[1] if factors[0] == factor else factors[0]
