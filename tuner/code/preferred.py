"""States in which what is needed is decided so, of many that are drawn."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from tuner.code.array_step import Step
from tuner.code.decided import NOTHING, Decided
from tuner.code.evaluation import Values
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
        mutants: constants, for which something is to be decided in some of them.
    """

    def __init__(self, step: Step, mutants: Sequence[Mutant]) -> None:
        same = dict[Decided, Decided]()  # whose members are compared but once
        needs = ((one, _needed(step, one)) for one in mutants)
        self._needs = {one: same.setdefault(need, need) for one, need in needs}
        self._program = step.program
        ends = {k for need in same for k, _ in need}
        self._decisions = step.part(step.graph.reached(ends), ends) if ends else None

    def of(self, drawn: Arrays, mutants: Sequence[Mutant], count: int) -> Arrays:
        """Some of the steps: first those in which something is decided that rarely is.

        Args:
            drawn: states and samples, a field each.
            mutants: those for which it counts, of those that were given.
            count: number of steps that are wanted.
        """
        if self._decisions is None:
            return [x[:count] for x in drawn]
        own, whole = len(self._program.state), len(drawn[0])
        given = by_node(self._program, drawn[:own], drawn[own:])
        values = self._decisions.values({k: given[k] for k in self._decisions.inputs})
        needs = Counter(self._needs[one] for one in mutants)
        met = dict(zip(needs, _met(values, list(needs), whole), strict=True))
        rare = [need for need, rows in met.items() if 0 < rows.mean() <= _RARE]
        total, chosen = sum(needs[need] for need in rare), list[int]()
        for need in rare:
            most = max(1, round(_SHARE * count * needs[need] / total))
            chosen += np.flatnonzero(met[need])[:most].tolist()
        rows = list(dict.fromkeys([*chosen, *range(whole)]))[:count]
        return [x[rows] for x in drawn]


def _needed(step: Step, one: Mutant) -> Decided:
    """What has to be decided for a constant to show."""
    node, found = step.graph.nodes[one.node], step.needed.get(one.node, NOTHING)
    if node.op == "choose" and one.at > 0:
        return found | {(node.args[0], one.at == 1)}
    return found


def _met(values: Values, needs: Sequence[Decided], count: int) -> np.ndarray:
    """In which steps all is decided as each needs it, ``(needs, count)``."""
    items = sorted({one for need in needs for one in need})
    truths = [np.broadcast_to(values[k] == truth, count) for k, truth in items]
    bits = np.packbits([*truths, np.ones(count, bool)], axis=1)  # eight steps in each byte
    places = {one: row for row, one in enumerate(items)}
    rows = ([len(items), *(places[one] for one in need)] for need in needs)
    met = np.empty((len(needs), bits.shape[1]), np.uint8)
    for found, row in zip(met, rows, strict=True):
        np.bitwise_and.reduce(bits[row], axis=0, out=found)
    return np.unpackbits(met, axis=1, count=count).astype(bool)
