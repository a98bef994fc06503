"""Constants that matter only where rounding decides, which no self-test can have."""

import numpy as np

from benchmarks.ranges import Ranges
from tuner.code.array_step import Step
from tuner.code.expected import EPS
from tuner.code.mutants import CHANGE, Mutant
from tuner.code.needed import Way, users_of
from tuner.code.operations import COMPARE

_CLOSE, _ALONE = 5.0, 0.5
"""Widths over the rounding of the number that is compared: within the first all values are closer
to the limit than steps of a self-test may be; within the other they are the limit, but for
rounding."""
_FAINT = 1 / 16
"""A change of a limit over the rounding of what is compared, from which that decides."""
_TURNED = {"lt": "gt", "le": "ge", "gt": "lt", "ge": "le"}


class Unsteady:
    """What is decided by rounding alone, since a limit is as good as the end of a range.

    Args:
        step: the filter's.
    """

    def __init__(self, step: Step) -> None:
        self._nodes, self._ranges = step.graph.nodes, Ranges(step.graph)
        self._eps = EPS[step.program.precision]
        self._compared = {frozenset(pair) for pair in step.decisions}
        self._users = users_of(step.graph, step.order)

    def always(self, one: Mutant, way: Way) -> bool:
        """Whether a change of a constant reaches a result only where rounding decides.

        Args:
            one: the constant.
            way: its way to the results.
        """
        if self._own(one) or self._differs_by_rounding(one):
            return True
        return any(self._only_by_rounding(k, truth) for k, truth in way.needed)

    def _differs_by_rounding(self, one: Mutant) -> bool:
        """Whether a constant only scales limits of differences from the number that it scales.

        What is left of the number after another one was subtracted has the rounding of both.
        """
        factor, users = self._nodes[one.node], self._users.get(one.node, [])
        if factor.op != "mul" or abs(self._value(one)) * CHANGE > _FAINT * self._eps:
            return False
        scaled = factor.args[1 - one.at]
        return bool(users) and all(self._is_left(k, one.node, scaled) for k in users)

    def _is_left(self, k: int, limit: int, scaled: int) -> bool:
        """Whether a comparison with a limit is one of what is left of a number."""
        node = self._nodes[k]
        if node.op not in _TURNED or limit not in node.args:
            return False
        left = self._nodes[node.args[1 - node.args.index(limit)]]
        if left.op != "sub" or left.args[0] != scaled:
            return False
        return self._nodes[left.args[1]].op == "mul"

    def _value(self, one: Mutant) -> float:
        return float(self._nodes[self._nodes[one.node].args[one.at]].value)

    def _only_by_rounding(self, k: int, truth: bool) -> bool:
        """Whether a comparison comes out so in no other steps."""
        parts = self._with_limit(k)
        if parts is None:
            return False
        op, x, limit = parts
        least, most = self._ranges.of(x)
        if op == "eq" and truth:
            return self._within(self._held_back(x, limit), limit, _CLOSE)
        if op in ("lt", "le", "gt", "ge"):
            below = (op in ("lt", "le")) == truth
            return self._within(limit - least if below else most - limit, limit, _CLOSE)
        return False

    def _own(self, one: Mutant) -> bool:
        """The same of the values for which a change of the constant changes what it is used for."""
        parts = self._with_limit(one.node)
        if parts is None:
            return False
        op, x, limit = parts
        least, most = self._ranges.of(x)
        moved = limit * (1 + CHANGE)
        if op in ("max", "min"):
            width = max(limit, moved) - least if op == "max" else most - min(limit, moved)
            both = frozenset((x, one.node)) in self._compared
            return self._within(width, limit, _CLOSE if both else _ALONE)
        if op == "eq":
            other = least <= moved <= most
            return not other and self._within(self._held_back(x, limit), limit, _CLOSE)
        if op in COMPARE:
            ends = max(min(limit, moved), least), min(max(limit, moved), most)
            return self._within(ends[1] - ends[0], limit, _CLOSE)
        return False

    def _held_back(self, k: int, limit: float) -> float:
        """How far a number that is held back at a limit may be beyond it; for others no end."""
        node = self._nodes[k]
        parts = self._with_limit(k) if node.op in ("max", "min") else None
        if parts is None or parts[2] != limit:
            return np.inf
        least, most = self._ranges.of(parts[1])
        return limit - least if node.op == "max" else most - limit

    def _within(self, width: float, limit: float, share: float) -> bool:
        return bool(width <= share * self._eps * abs(limit))

    def _with_limit(self, k: int) -> tuple[str, int, float] | None:
        """What is done to a number and a constant, in this order."""
        node = self._nodes[k]
        if len(node.args) != 2:
            return None
        for at, op in ((1, node.op), (0, _TURNED.get(node.op, node.op))):
            limit = self._nodes[node.args[at]]
            if limit.op == "constant" and limit.kind == "real" and np.isfinite(limit.value):
                return op, node.args[1 - at], float(limit.value)
        return None
