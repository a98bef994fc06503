"""Equality of formulas, tested at random points.

Formulas that agree at random points of all that goes into them agree everywhere, as polynomials
do. A truth value is a number between 0 and 1 here, and what it chooses is a mean with that weight:
formulas of truth values agree if these do, and no way that they may go is left out. What is
compared is taken as any function of both numbers, and so is the larger of two: else formulas would
be called the same that agree only where the points lie. Half of the points find what is the same,
the other half confirms it.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tuner.code.operations import COMPARE, in_numpy

COUNT = 8
_SMALL = 1e-6
_NAN, _INFINITY = 0.739, 61.7
"""Stand-ins for NaN and for infinity: any number will do."""
_SUBSTITUTES: Mapping[str, Callable[..., Any]] = {
    "sqrt": lambda x: np.sqrt(np.abs(x)),
    "log": lambda x: np.log(np.abs(x)),
    "log1p": lambda x: np.log(np.abs(1 + x)),
    "asin": lambda x: 1.1 * np.arctan(x),
    "acos": lambda x: 1 - 1.1 * np.arctan(x),
    "acosh": lambda x: np.arcsinh(x - 1),
    "atanh": lambda x: 0.9 * np.arctan(x),
    "lgamma": np.sin,
    "pow": lambda x, y: np.abs(x) ** y,
    "max": lambda x, y: 0.6 * x + 0.5 * y,
    "min": lambda x, y: 0.5 * x + 0.6 * y,
    "floor": lambda x: 0.97 * x,
    "ceil": lambda x: 1.03 * x,
    "round": lambda x: 1.01 * x,
    "rem": lambda x, y: 0.8 * x + 0.1 * y,
    "not": lambda x: 1 - x,
    "and": lambda x, y: x * y,
    "or": lambda x, y: x + y - x * y,
    "xor": lambda x, y: x + y - 2 * x * y,
    "isnan": lambda x: 0.5 + 0.4 * np.sin(7 * x),
    "is_finite": lambda x: 0.5 + 0.4 * np.sin(5 * x),
    "choose": lambda c, yes, no: c * yes + (1 - c) * no,
    **{
        name: lambda x, y, k=k: 0.5 + 0.4 * np.sin(0.3 * k * x + 0.7 * y)
        for k, name in enumerate(sorted(COMPARE), 1)
    },
}
"""Substitutes for functions that decide or are not defined everywhere: formulas that are equal with
one function are equal with any."""


class Points:
    """Values of nodes at random points, computed on demand.

    Args:
        nodes: of a graph, which may grow.
        close: relative tolerance of the values of one formula, by rounding of the
            constants in it.
    """

    def __init__(self, nodes: list[Any], close: float) -> None:
        self._nodes, self._values, self._close = nodes, list[np.ndarray](), close
        self._draw = np.random.default_rng(0)

    def same(self, one: int, other: int) -> bool:
        """Whether two nodes are the same formula but for the order of its sums and products."""
        if one == other:
            return True
        if {self._nodes[one].kind, self._nodes[other].kind} != {"real"}:
            return False
        a, b = self._at(one), self._at(other)
        close = (np.abs(a - b) <= self._close * np.abs(a)) & (np.abs(a) > _SMALL)
        return bool(close[: COUNT // 2].all() and close[COUNT // 2 :].all())

    def _at(self, node: int) -> np.ndarray:
        for k in range(len(self._values), node + 1):
            with np.errstate(all="ignore"):
                self._values.append(np.asarray(self._value(self._nodes[k]), float))
        return self._values[node]

    def _value(self, node: Any) -> Any:
        given = [self._values[k] for k in node.args]
        if node.op == "constant":
            number = np.full(COUNT, node.value, float)
            return np.nan_to_num(number, nan=_NAN, posinf=_INFINITY, neginf=-_INFINITY)
        if node.op == "input":
            low, high = (0.1, 0.9) if node.kind == "truth" else (0.4, 1.6)
            return self._draw.uniform(low, high, COUNT)
        if node.op == "convert":
            return given[0] if node.kind != "whole" else 1.7 * given[0]
        function = _SUBSTITUTES.get(node.op)
        return in_numpy(node.op, *given) if function is None else function(*given)
