"""Scalars of a graph as C expressions: what all lanes share."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from tuner.code.expression import converted, limited, operation
from tuner.code.graph import Graph
from tuner.code.literal import literal, type_of
from tuner.code.nodes import Node
from tuner.code.operations import Kind

_OF_TURNS = {"sin": "{0}.sine", "cos": "{0}.cosine", "tan": "{0}.sine / {0}.cosine"}

_NOTHING: Mapping[int, str] = MappingProxyType({})


class Scalars:
    """Statements of a function.

    Args:
        graph: of the nodes.

    Attributes:
        names: of nodes that are variables.
        lines: the statements so far.
        turns: whether an angle has had its sine and cosine computed.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.names: dict[int, str] = {}
        self.lines: list[str] = []
        self.turns = False
        self._angles: set[int] = set()

    def begin(self) -> None:
        """Begin another function."""
        self.names, self.lines, self._angles = {}, [], set()

    def state(self, order: Iterable[int], then: Mapping[int, str] = _NOTHING) -> None:
        """Add statements for nodes.

        Args:
            order: nodes, each after those that it depends on.
            then: statements that follow that of a node.
        """
        for k in order:
            node = self.graph.nodes[k]
            if k not in self.names and node.op not in ("constant", "input"):
                text = self.text(k)
                self.names[k] = f"t{k}"
                self.lines.append(f"const {type_of(node.kind, 'double')} t{k} = {text};")
                self.lines += [then[k]] if k in then else []

    def text(self, k: int) -> str:
        """The expression of a node, by the names of its operands."""
        twice = self.doubled(k)
        if twice:
            return twice
        node = self.graph.nodes[k]
        given = [self.name(one) for one in node.args]
        kinds: list[Kind] = [self.graph.nodes[one].kind for one in node.args]
        if node.op == "choose":
            return f"{given[0]} ? {given[1]} : {given[2]}"
        if node.op in _OF_TURNS:
            return self._of_turn(node)
        if node.op == "convert":
            return converted(given[0], kinds[0], node.kind, "double")
        if node.op in ("max", "min"):
            for at, entry in enumerate(node.args):
                if self.graph.is_constant(entry):
                    return limited(node.op, given[1 - at], given[at])
        return operation(node.op, given, kinds, "double")

    def doubled(self, k: int) -> str:
        """Twice a number as a sum, which leaves the multipliers free; "" for any other node."""
        node = self.graph.nodes[k]
        for at, other in (node.args, node.args[::-1]) if node.op == "mul" else ():
            if node.kind == "real" and self.graph.is_constant(at, 2.0):
                return f"{self.name(other)} + {self.name(other)}"
        return ""

    def _of_turn(self, node: Node) -> str:
        """Sine, cosine or tangent of an angle, of which the first two are computed once."""
        (x,) = node.args
        self.turns = True
        if x not in self._angles:
            self._angles.add(x)
            self.lines.append(f"const pair turned{x} = circular({self.name(x)});")
        return _OF_TURNS[node.op].format(f"turned{x}")

    def name(self, k: int) -> str:
        """A node as an operand."""
        node = self.graph.nodes[k]
        if node.op != "constant":
            return self.names[k]
        text = literal(node.value, node.kind, "double")
        return f"({text})" if text.startswith(("-", "(")) else text


def read(kind: Kind, place: str) -> str:
    """A number of an array, as the kind of number that it is."""
    return {"real": place, "whole": f"(int){place}", "truth": f"0.0 != {place}"}[kind]
