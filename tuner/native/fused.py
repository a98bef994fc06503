"""Sums of products in the order in which a processor multiplies and adds at once."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

from tuner.code.graph import Graph
from tuner.native.loop import Carried, Loop
from tuner.native.rewriting import Rewriter

_OPPOSITE = {"add": "sub", "sub": "add"}


def fused(loop: Loop) -> Loop:
    """The same loop with fewer operations, but for rounding.

    Of a sum of two products, which is added to a number, each is added by itself; of a product of
    three factors the pair is multiplied that is needed elsewhere.

    >>> graph = Graph()
    >>> x, k, g = (graph.input(("s", n)) for n in range(3))
    >>> both = graph.apply("add", graph.apply("mul", k, g), graph.apply("mul", x, g))
    >>> after = graph.apply("sub", x, both)
    >>> found = fused(Loop(graph, [Carried(x, x, after)], [], [], 0))
    >>> nodes = [found.graph.nodes[k] for k in found.graph.reached([found.carried[0].after])]
    >>> [node.op for node in nodes if node.args]
    ['mul', 'mul', 'sub', 'sub']
    """
    writer = _Writer(loop)
    known = writer.known

    def written(rows: list[list[int]]) -> list[list[int]]:
        return [[known[k] for k in row] for row in rows]

    carried = [Carried(*(known[k] for k in cell)) for cell in loop.carried]
    return replace(
        loop,
        graph=writer.new,
        carried=carried,
        total=written(loop.total),
        kept=written(loop.kept),
    )


class _Writer:
    """All nodes of a loop, written into a new graph.

    Attributes:
        new: the graph.
        known: its nodes by those of the loop.
    """

    def __init__(self, loop: Loop) -> None:
        self.old, self.new = loop.graph, Graph()
        rows = [*loop.carried, *loop.kept, *loop.total]
        roots = [k for row in rows for k in row]
        order = self.old.reached(roots)
        nodes = self.old.nodes
        self._uses = Counter(roots) + Counter(part for k in order for part in nodes[k].args)
        self._products = {frozenset(nodes[k].args): k for k in order if nodes[k].op == "mul"}
        self.known: dict[int, int] = {}
        plain = Rewriter(self.old, self.new)
        for k in order:
            found = self._product(k) or self._sum(k)
            if found is None:
                plain.write(k, self.known)
            else:
                self.known[k] = found

    def _once(self, k: int, *ops: str) -> bool:
        """Whether a node is one of these operations, and needed in one place."""
        return self.old.nodes[k].op in ops and self._uses[k] == 1

    def _pairs(self, k: int) -> Iterator[tuple[int, int]]:
        """The operands of a node, in both orders where it has them."""
        x, y = self.old.nodes[k].args
        yield x, y
        if self.old.nodes[k].op != "sub":
            yield y, x

    def _product(self, k: int) -> int | None:
        """(a b) c as a (b c), where b c is there already."""
        if self.old.nodes[k].op != "mul":
            return None
        for inner, c in self._pairs(k):
            for a, b in self._pairs(inner) if self._once(inner, "mul") else ():
                there = self.known.get(self._products.get(frozenset((b, c)), -1))
                if there is not None:
                    return self.new.apply("mul", self.known[a], there)
        return None

    def _sum(self, k: int) -> int | None:
        """a + (b c + d e) as (a + b c) + d e."""
        op = self.old.nodes[k].op
        for a, inner in self._pairs(k) if op in _OPPOSITE else ():
            x, y = self.old.nodes[inner].args if self._once(inner, *_OPPOSITE) else (-1, -1)
            if x >= 0 and self._once(x, "mul") and self._once(y, "mul"):
                first = self.new.apply(op, self.known[a], self.known[x])
                then = op if self.old.nodes[inner].op == "add" else _OPPOSITE[op]
                return self.new.apply(then, first, self.known[y])
        return None
