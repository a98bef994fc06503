"""The constants that no step of a self-test shows yet, and where to look for such steps."""

from collections import Counter
from collections.abc import Collection, Mapping

import numpy as np

from tuner.code.array_step import Step
from tuner.code.expected import LONG
from tuner.code.mutants import Mutant, uses_of
from tuner.code.needed import Way

_MET = 16
"""Steps in which all is decided as a constant needs it, from which one without any effect is given
up."""


class Hidden:
    """Constants that no chosen step shows.

    Args:
        step: whose constants they are.
        given_up: those that are not looked for.

    Attributes:
        mutants: these, but those of which is proven that they have no effect.
        idle: those without any effect so far, the latter among them.
        uses: of results with a constant, in long steps; those that did not show yet.
    """

    def __init__(self, step: Step, given_up: Collection[Mutant] = ()) -> None:
        self._step = step
        self.mutants: list[Mutant] = [one for one in step.mutants if one not in given_up]
        self.idle = set(self.mutants)
        long = len(step.order) > LONG
        self.uses = set(uses_of(step.graph, step.order, self.mutants) if long else ())
        self._proven = set[Mutant]()
        self._known = dict[Mutant, Way | None]()
        self._met = Counter[Mutant]()

    def leave(self, stays: np.ndarray) -> None:
        """Keep some."""
        pairs = zip(self.mutants, stays, strict=True)
        self.mutants = [one for one, hidden in pairs if hidden]
        self.idle &= {*self.mutants, *self._proven}

    def leave_proven(self) -> None:
        """Keep none that reaches no result, whatever is decided."""
        proven = np.array([self._way(one) is None for one in self.mutants], bool)
        self._proven |= {one for one, never in zip(self.mutants, proven, strict=True) if never}
        self.leave(~proven)

    def _way(self, one: Mutant) -> Way | None:
        if one not in self._known:
            self._known[one] = self._step.ways.way(one)
        return self._known[one]

    def count(self, values: Mapping[int, np.ndarray], good: np.ndarray) -> None:
        """Take note of the decisions in steps, of which some are good.

        Args:
            values: all nodes, ``(B,)`` or ``(1,)`` each.
            good: which steps are, ``(B,)``.
        """
        for one in self.mutants:
            way = self._known.get(one)
            if way is not None:
                met = good.copy()
                for k, truth in way.needed:
                    met &= values[k] == truth
                self._met[one] += int(met.sum())

    @property
    def open(self) -> list[Mutant]:
        """Those that may show yet."""
        return [one for one in self.mutants if self._at_limits(one) or not self._given_up(one)]

    @property
    def only_at_limits(self) -> bool:
        """Whether those that may show yet do so close to a limit, if at all."""
        return all(self._at_limits(one) and not self._equal(one) for one in self.open)

    def _given_up(self, one: Mutant) -> bool:
        return one in self.idle and self._met[one] >= _MET

    def _at_limits(self, one: Mutant) -> bool:
        way = self._known.get(one)
        return one.limit or self._summand(one) or (way is not None and bool(way.turned))

    def _summand(self, one: Mutant) -> bool:
        """Whether it is added, which shows where the rest of the sum is not much larger."""
        return self._step.graph.nodes[one.node].op == "add"

    def _equal(self, one: Mutant) -> bool:
        """Whether it decides if numbers are equal, which needs no limit to be close."""
        way = self._known.get(one)
        nodes = self._step.graph.nodes
        return way is not None and any(nodes[k].op in ("eq", "ne") for k in way.turned)

    def wanted(self, *, moving: bool = False) -> set[int]:
        """The operations that decide whether those show that may, or those with an effect."""
        found = set[int]()
        for one in self.open:
            if moving and one in self.idle and one not in self._step.own_limits:
                continue
            way = self._way(one)
            if way is not None:
                found |= way.turned | {k for k, _ in way.needed}
            if one.limit or self._step.graph.nodes[one.node].op in ("max", "min", "add"):
                found.add(one.node)
        return found
