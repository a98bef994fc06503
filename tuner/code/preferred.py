"""States in which what is needed is decided so, of many that are drawn."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

import numpy as np

from tuner.code.array_step import Step
from tuner.code.decided import NOTHING, Decided
from tuner.code.evaluation import Evaluation, Values
from tuner.code.mutants import Mutant
from tuner.code.states import Arrays, by_node

_RARE = 1 / 4
"""Share of the states up to which decisions are rare."""
_SHARE = 1 / 2
"""Share of the steps that are chosen for them."""


class Preferred:
    """The choice of steps in which rare decisions are taken.

    Args:
        step: the filter's.
        needs: what is to be decided in some of them.
    """

    def __init__(self, step: Step, needs: Iterable[Decided]) -> None:
        self._step = step
        self._ends = {k for need in needs for k, _ in need}

    def of(self, drawn: Arrays, needs: Mapping[Decided, int], count: int) -> Arrays:
        """Some of the steps: first those in which something is decided that rarely is.

        Args:
            drawn: states and samples, a field each.
            needs: what is to be decided in some, and how much each counts.
            count: number of steps that are wanted.
        """
        if not self._ends:
            return [x[:count] for x in drawn]
        own, whole = len(self._step.program.state), len(drawn[0])
        given = by_node(self._step.program, drawn[:own], drawn[own:])
        values = self._decisions.values({k: given[k] for k in self._decisions.inputs})
        met = {need: _met(values, need, whole) for need in needs}
        rare = [need for need, rows in met.items() if 0 < rows.mean() <= _RARE]
        total, chosen = sum(needs[need] for need in rare), list[int]()
        for need in rare:
            most = max(1, round(_SHARE * count * needs[need] / total))
            chosen += np.flatnonzero(met[need])[:most].tolist()
        rows = list(dict.fromkeys([*chosen, *range(whole)]))[:count]
        return [x[rows] for x in drawn]

    @cached_property
    def _decisions(self) -> Evaluation:
        return self._step.part(self._step.graph.reached(self._ends), self._ends)


def needs_of(step: Step, mutants: Sequence[Mutant]) -> Counter[Decided]:
    """What has to be decided for constants to show, and for how many."""
    return Counter(_needed(step, one) for one in mutants)


def _needed(step: Step, one: Mutant) -> Decided:
    node, found = step.graph.nodes[one.node], step.needed.get(one.node, NOTHING)
    if node.op == "choose" and one.at > 0:
        return found | {(node.args[0], one.at == 1)}
    return found


def _met(values: Values, need: Decided, count: int) -> np.ndarray:
    """In which steps all is decided as it is needed."""
    found = np.ones(count, bool)
    for k, truth in need:
        found &= values[k] == truth
    return found
