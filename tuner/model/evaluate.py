"""Values of expressions, in NumPy or traced by JAX."""

import operator
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tuner.model.expression import Call, Name, Node, Number

_OPERATORS: dict[str, Any] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "neg": operator.neg,
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
_OF_NUMPY = {
    "asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2",
    "min": "minimum", "max": "maximum",
}  # fmt: skip


class Values:
    """An evaluator of expressions for given names; repeated parts are evaluated once.

    Args:
        values: by name.
        library: ``numpy`` or ``jax.numpy``.
        dtype: of the results of :meth:`vector` and :meth:`matrix`.
    """

    def __init__(self, values: Mapping[str, Any], library: Any, dtype: Any) -> None:
        self.values, self.library, self.dtype = values, library, dtype
        self._known: dict[Node, Any] = {}

    def __call__(self, node: Node) -> Any:
        """The value of one expression; a Python number where it is constant."""
        if isinstance(node, Number):
            return node.value
        if isinstance(node, Name):
            return self.values[node.name]
        if node not in self._known:
            self._known[node] = self._call(node)
        return self._known[node]

    def _call(self, node: Call) -> Any:
        if node.function == "**":
            return self._power(*node.arguments)
        arguments = [self(each) for each in node.arguments]
        if node.function in _OPERATORS:
            return _OPERATORS[node.function](*arguments)
        return getattr(self.library, _OF_NUMPY.get(node.function, node.function))(*arguments)

    def _power(self, base: Node, exponent: Node) -> Any:
        if isinstance(exponent, Number) and exponent.value == int(exponent.value):
            return self(base) ** int(exponent.value)  # products, which have a derivative at 0
        return self(base) ** self(exponent)

    def vector(self, nodes: Sequence[Node]) -> Any:
        """The values of some expressions, ``(k,)``."""
        if all(isinstance(node, Number) for node in nodes):
            return self.library.asarray(np.array([self(node) for node in nodes]), self.dtype)
        return self.library.stack([self.library.asarray(self(node), self.dtype) for node in nodes])

    def matrix(self, rows: Sequence[Sequence[Node]]) -> Any:
        """The values of rows of expressions, ``(n, k)``."""
        flat = [node for row in rows for node in row]
        return self.vector(flat).reshape(len(rows), -1)
