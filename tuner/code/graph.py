"""A calculation as a graph of scalars, with equal nodes merged and constants folded."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from tuner.code.nodes import Node
from tuner.code.operations import COMMUTE, LOGIC, Kind, kind_of, worked_out
from tuner.code.points import Points
from tuner.code.simplify import simpler


class TooLargeError(ValueError):
    """A graph above its size limit."""


class Graph:
    """Nodes in topological order; an algebra for an interpreter.

    Args:
        precision: the type of its real numbers.
        halves: whether the mean of two mirrored entries of a symmetric matrix is one of
            them.
        most: limit of nodes; None: none.

    Attributes:
        means: nodes that stand for half their sum with an equal one.

    Raises:
        TooLargeError: as it grows beyond that.

    >>> graph = Graph()
    >>> x = graph.input("x")
    >>> one = graph.constant(1.0)
    >>> graph.apply("mul", x, one) == x
    True
    """

    def __init__(
        self,
        precision: type[np.floating] = np.float64,
        *,
        halves: bool = True,
        most: int | None = None,
    ) -> None:
        self.precision, self.halves, self.most = precision, halves, most
        self.nodes: list[Node] = []
        self.means = set[int]()
        self.points = Points(self.nodes, 1e-10 if precision is np.float64 else 4e-6)
        self._known: dict[Any, int] = {}

    def input(self, name: Any, kind: Kind = "real") -> int:
        """A number that is known only at run time."""
        return self._node(Node("input", (), name, kind))

    def constant(self, value: Any) -> int:
        """A number; real ones in the precision of the graph."""
        kind = kind_of(value)
        number = {"real": self.precision, "truth": bool, "whole": int}[kind](value)
        return self._node(Node("constant", (), number, kind))

    def apply(self, op: str, *entries: int) -> int:
        """One operation, simplified."""
        if all(self.is_constant(k) for k in entries):
            return self.constant(worked_out(op, *(self.nodes[k].value for k in entries)))
        found = simpler(self, op, entries)
        return self.make(op, *entries) if found is None else found

    def found(self, op: str, *entries: int) -> int | None:
        """The node of a real operation that is there already; None: it is not."""
        args = tuple(sorted(entries)) if op in COMMUTE else entries
        return self._known.get((op, args, None, "real"))

    def make(self, op: str, *entries: int) -> int:
        """One operation without simplification."""
        kinds = [self.nodes[k].kind for k in entries]
        kind: Kind = "truth" if op in LOGIC else "real" if "real" in kinds else kinds[0]
        return self._node(Node(op, entries, None, kind))

    def choose(self, condition: int, no: int, yes: int) -> int:
        """One of two."""
        if self.is_constant(condition):
            return yes if self.nodes[condition].value else no
        yes, no = self._branch(condition, yes, 1), self._branch(condition, no, 2)
        if no == yes or self._is_missing(condition, yes, no):
            return no
        if self.nodes[condition].op == "not":
            return self.choose(self.nodes[condition].args[0], yes, no)
        if self.nodes[yes].kind == "truth":
            against = self.apply("and", self.apply("not", condition), no)
            return self.apply("or", self.apply("and", condition, yes), against)
        return self._node(Node("choose", (condition, yes, no), None, self.nodes[yes].kind))

    def _branch(self, condition: int, entry: int, place: int) -> int:
        """One of two, which is not chosen by the same condition again."""
        node = self.nodes[entry]
        return node.args[place] if node.op == "choose" and node.args[0] == condition else entry

    def _is_missing(self, condition: int, yes: int, no: int) -> bool:
        """Whether NaN is chosen for a number that is NaN."""
        test, chosen = self.nodes[condition], self.nodes[yes]
        constant = chosen.op == "constant" and chosen.kind == "real"
        return (
            constant and test.op == "isnan" and test.args == (no,) and bool(np.isnan(chosen.value))
        )

    def convert(self, entry: int, dtype: np.dtype) -> int:
        """A conversion to another kind of number."""
        kind = kind_of(dtype)
        if kind == self.nodes[entry].kind:
            return entry
        if self.is_constant(entry):
            return self.constant(np.asarray(self.nodes[entry].value).astype(dtype)[()])
        if kind == "truth":
            zero = self.constant(0 if self.nodes[entry].kind == "whole" else 0.0)
            return self.apply("ne", entry, zero)
        if kind == "real" and self.nodes[entry].kind == "truth":  # with two constants like others
            return self.make("choose", entry, self.constant(1.0), self.constant(0.0))
        return self._node(Node("convert", (entry,), None, kind))

    def is_constant(self, entry: int, value: float | None = None) -> bool:
        """Whether a node is a constant, or a given one."""
        node = self.nodes[entry]
        if node.op != "constant" or value is None:
            return node.op == "constant"
        return node.kind != "truth" and bool(node.value == value)

    def reached(self, roots: Iterable[int]) -> list[int]:
        """The nodes that others depend on, themselves included, in order."""
        seen, open_ = set[int](), list(roots)
        while open_:
            k = open_.pop()
            if k not in seen:
                seen.add(k)
                open_ += self.nodes[k].args
        return sorted(seen)

    def _node(self, node: Node) -> int:
        args = tuple(sorted(node.args)) if node.op in COMMUTE else node.args
        value = repr(node.value) if node.op == "constant" else node.value
        key = node.op, args, value, node.kind
        if key not in self._known:
            if len(self.nodes) == self.most:
                raise TooLargeError(f"the step takes more than {self.most} operations")
            self._known[key] = len(self.nodes)
            self.nodes.append(node)
        return self._known[key]
