"""Whether two nodes are the same formula: they have to agree at random points.

Formulas that agree at random points of all that goes into them agree everywhere, as polynomials
do. What a formula compares is taken as any function of both numbers that is true as often as not,
and the larger of two numbers as any function of them: else formulas would be called the same that
agree only where the points lie. Half of the points find what is the same, the other half confirms.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tuner.code.operations import COMPARE, in_numpy

COUNT = 8
_ANYWHERE: Mapping[str, Callable[..., Any]] = {
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
    "isnan": lambda x: np.sin(7 * x) > 0,
    "is_finite": lambda x: np.sin(5 * x) > 0,
    **{
        name: lambda x, y, k=k: np.sin(3.0 * k * x + 5.0 * y) > 0
        for k, name in enumerate(sorted(COMPARE), 1)
    },
}
"""Functions that do not exist everywhere or that decide, by others: what is the same formula of
one function is the same of any."""
_SMALL = 1e-6


class Points:
    """Values of nodes at random points, worked out as far as somebody asks.

    Args:
        nodes: of a graph, which may grow.
        close: how far the values of one formula may be apart, relative: what rounding makes of the
            constants in it.
    """

    def __init__(self, nodes: list[Any], close: float) -> None:
        self._nodes, self._values, self._close = nodes, list[np.ndarray](), close
        self._draw = np.random.default_rng(0)

    def same(self, one: int, other: int) -> bool:
        """Whether two nodes are the same formula but for the order of its sums and products."""
        if one == other:
            return True
        a, b = self._at(one), self._at(other)
        if a.dtype != float or b.dtype != float:
            return False
        close = np.abs(a - b) <= self._close * np.abs(a)
        large = np.abs(a) > _SMALL
        return bool((close & large)[: COUNT // 2].all() and (close & large)[COUNT // 2 :].all())

    def _at(self, node: int) -> np.ndarray:
        for k in range(len(self._values), node + 1):
            self._values.append(self._value(self._nodes[k]))
        return self._values[node]

    def _value(self, node: Any) -> np.ndarray:
        given = [self._values[k] for k in node.args]
        with np.errstate(all="ignore"):
            if node.op == "constant":
                return np.full(COUNT, node.value, None if node.kind != "real" else float)
            if node.op == "input":
                return self._drawn(node.kind)
            if node.op == "choose":
                condition, yes, no = given
                return np.asarray(np.where(condition, yes, no))
            if node.op == "convert":
                kinds = {"real": float, "truth": bool, "whole": int}
                return np.asarray(given[0]).astype(kinds[node.kind])
            if node.op in _ANYWHERE:
                return np.asarray(_ANYWHERE[node.op](*given))
            return np.asarray(in_numpy(node.op, *given))

    def _drawn(self, kind: str) -> np.ndarray:
        if kind == "real":
            return self._draw.uniform(0.4, 1.6, COUNT)
        if kind == "truth":
            return self._draw.random(COUNT) < 0.5
        return self._draw.integers(1, 9, COUNT)
