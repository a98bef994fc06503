"""Whether two formulas are one in exact arithmetic."""

import operator
import random
from collections.abc import Callable, Hashable, Mapping
from fractions import Fraction

from tuner.code.graph import Graph

_PRIME = 2**521 - 1
_RATIONAL: Mapping[str, Callable[..., int]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "neg": operator.neg,
    "div": lambda x, y: x * pow(y, -1, _PRIME),
}


class Identities:
    """The numbers of a graph in exact arithmetic, modulo a prime, at a random point.

    Sums, products and quotients are worked out; anything else (an input, a sine, one of two
    numbers, a truth value) is a random number of its own, one for all operations with the same
    operands. Two different polynomials of degree d agree at such a point with a probability of at
    most d over the prime (Schwartz and Zippel), which has 521 bits, d as many as a formula has
    products in a row: that two numbers are one is told from the formulas as surely as anything is.
    Constants count as they stand in the code, rounded.

    Args:
        graph: the formulas; may grow.

    >>> graph = Graph()
    >>> x, y = graph.input("x"), graph.input("y")
    >>> both, less = graph.apply("add", x, y), graph.apply("sub", x, y)
    >>> product = graph.apply("mul", both, less)
    >>> squares = graph.apply("sub", graph.apply("mul", x, x), graph.apply("mul", y, y))
    >>> Identities(graph).same(product, squares), Identities(graph).same(both, less)
    (True, False)
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._draw = random.Random(0)
        self._values = list[int]()
        self._own = dict[Hashable, int]()

    def same(self, first: int, second: int) -> bool:
        """Whether two nodes are one but for rounding."""
        return first == second or self._of(first) == self._of(second)

    def _of(self, k: int) -> int:
        for at in range(len(self._values), k + 1):
            self._values.append(self._worked_out(at))
        return self._values[k]

    def _worked_out(self, k: int) -> int:
        node = self._graph.nodes[k]
        if node.op == "constant":
            return self._constant(node.value)
        if node.op == "input":
            return self._drawn(("input", node.value))
        given = [self._values[part] for part in node.args]
        if node.op == "choose" and given[1] == given[2]:
            return given[1]
        if node.kind == "real" and node.op in _RATIONAL and (node.op != "div" or given[1]):
            return _RATIONAL[node.op](*given) % _PRIME
        return self._drawn((node.op, node.kind, *given))

    def _constant(self, value: object) -> int:
        if isinstance(value, bool):
            return self._drawn(value)
        try:
            exact = Fraction(float(value))  # type: ignore[arg-type]
        except (ValueError, OverflowError):  # no number, or infinite
            return self._drawn(repr(float(value)))  # type: ignore[arg-type]
        return exact.numerator * pow(exact.denominator, -1, _PRIME) % _PRIME

    def _drawn(self, key: Hashable) -> int:
        """A random number, one for what has the same key."""
        if key not in self._own:
            self._own[key] = self._draw.randrange(_PRIME)
        return self._own[key]
