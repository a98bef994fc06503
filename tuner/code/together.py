"""Constants of a long step whose numbers in C are not those of the formulas.

C with loops has one number where the formulas have many: a change of it moves what all of them
move. And it divides by a number where the formulas multiply by its inverse, which becomes smaller
where the number becomes larger.
"""

from collections import Counter
from collections.abc import Hashable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from tuner.code.array_step import Step
from tuner.code.chosen import Also
from tuner.code.detection import detected
from tuner.code.expected import EPS, Expected
from tuner.code.mutants import CHANGE, WHOLE, Mutant
from tuner.code.nodes import Node
from tuner.code.states import Arrays

_APART = 64
"""Nodes between equal constants from which they belong to different operations on arrays."""
_LEAST, _AMPLE = 2.0, 8.0
"""The move of equal constants together, over its tolerance, that is worth a step; and from which
they need no other one."""

_PART = 96
"""Factors that are changed together: what depends on none of them is not worked out."""


class _Best(NamedTuple):
    """The step in which a group moves most: by how much, and what else shows there."""

    size: float
    step: Arrays
    shown: list[Hashable]
    groups: list[int]


class Together:
    """The steps in which equal constants of equal operations move most.

    Args:
        step: whose constants they are.

    Attributes:
        alone: constants that are the only ones of their operation.
        whole: products that formulas have once, and C as half a sum with an equal one, with their
            group.
    """

    def __init__(self, step: Step) -> None:
        self._step, self._known = step, set(step.order)
        self._group = dict[Mutant, int]()
        last = dict[tuple[str, int, float], Mutant]()
        for one in step.mutants:
            node = step.graph.nodes[one.node]
            key = node.op, one.at, float(step.graph.nodes[node.args[one.at]].value)
            before = last.get(key)
            apart = before is None or one.node - before.node > _APART
            self._group[one] = len(self._group) if apart else self._group[last[key]]
            last[key] = one
        count = Counter(self._group.values())
        self.alone = {one for one, group in self._group.items() if count[group] == 1}
        self.whole = self._halved()
        self._constantless = {*self.whole.values()} - {*self._group.values()}
        # What is zero but for rounding, as those sums are, was evaluated in double.
        self._rounding = EPS[step.program.precision] / EPS["double"]
        self._best = dict[int, _Best]()
        self._looked = dict[int, np.ndarray]()
        self._sure = dict[int, np.ndarray]()

    def _halved(self) -> dict[int, int]:
        """Products of operations on arrays of which C takes half of the sum with the mirrored one.

        Formulas have no half where both are one, as on the diagonal, or the same but for rounding.
        """
        graph, members, last = self._step.graph, dict[int, list[int]](), -_APART
        for one, group in self._group.items():
            added = graph.nodes[graph.nodes[one.node].args[1 - one.at]]
            if graph.nodes[one.node].op == "mul" and added.op == "add":
                members.setdefault(group, []).extend(added.args)
        group = len(self._group)
        for k in sorted(graph.means.intersection(self._step.order)):
            group += k - last > _APART
            members.setdefault(group, []).append(k)
            last = k
        found = dict[int, int]()
        for group, some in members.items():
            parts = {part for k in some for part in self._factors(k)}
            for k in range(min(some) - _APART, max(some) + _APART + 1):
                if k in self._known and parts.issuperset(self._factors(k) or {-1}):
                    found[k] = group
        return found

    def _factors(self, k: int) -> tuple[int, ...]:
        node = self._step.graph.nodes[k]
        return node.args if node.op == "mul" else ()

    def look(self, moves: Mapping[Mutant, np.ndarray]) -> None:
        """Sum up moves of constants in steps, ``(B,)`` each, of which none is large.

        Operations of which all constants show by themselves are left out.
        """
        self._looked, self._sure = {}, {}
        hidden = {self._group[one] for one in moves if one.at != WHOLE}
        for one, size in moves.items():
            if one.at == WHOLE and self.whole[one.node] not in hidden | self._constantless:
                continue
            group = self.whole[one.node] if one.at == WHOLE else self._group[one]
            moved = size * self._rounding if one.at == WHOLE else size
            self._looked[group] = self._looked.get(group, 0.0) + moved**2
            if one.at != WHOLE or group in self._constantless:
                self._sure[group] = self._sure.get(group, 0.0) + moved**2

    def take(self, steps: Arrays, also: Also) -> None:
        """Keep those of these steps, a field each, that are the best so far.

        Args:
            steps: those of the last look.
            also: what else each of them shows.
        """
        for group, squares in self._looked.items():
            at = int(np.argmax(squares))
            size = float(np.sqrt(squares[at]))
            before = self._best.get(group)
            if size >= _LEAST and (before is None or size > before.size):
                ample = [k for k, more in self._sure.items() if more[at] >= _AMPLE**2]
                groups = [group, *(k for k in ample if k != group)]
                self._best[group] = _Best(size, [x[at] for x in steps], also(at), groups)

    def steps(self) -> Iterator[tuple[Arrays, list[Hashable], list[int]]]:
        """The best steps, that of the largest moves first, and what constants and groups show."""
        for one in sorted(self._best.values(), key=lambda one: -one.size):
            yield one.step, one.shown, one.groups


class Inverses:
    """The steps in which factors that only decide show when they become smaller.

    Args:
        step: whose constants they are.
    """

    def __init__(self, step: Step) -> None:
        nodes = step.graph.nodes
        self._step = step
        self._factors = [one for one in step.mutants if _is_factor(one, step.limits, nodes)]
        self._found = list[tuple[Arrays, list[Hashable]]]()

    def look(self, right: Expected, steps: Arrays, also: Also) -> None:
        """Keep those of these steps, a field each, that show a factor that none did before.

        Args:
            right: their results.
            steps: the steps.
            also: what else each of them shows.
        """
        if not self._factors:
            return
        parts = [self._factors[at : at + _PART] for at in range(0, len(self._factors), _PART)]
        found = [detected(self._step, part, right, 2.0, change=-CHANGE) for part in parts]
        shows = np.concatenate(found)
        some = np.asarray(shows.any(axis=1))
        best = shows[some].argmax(axis=1)
        seen = [one for one, shown in zip(self._factors, some, strict=True) if shown]
        for at in sorted({*best.tolist()}):
            own = [(one, "inverse") for one, k in zip(seen, best, strict=True) if k == at]
            self._found.append(([x[at] for x in steps], [*also(at), *own]))
        self._factors = [one for one, shown in zip(self._factors, some, strict=True) if not shown]

    def steps(self) -> list[tuple[Arrays, list[Hashable]]]:
        """The steps, and what they show."""
        return self._found


def _is_factor(one: Mutant, limits: set[Mutant], nodes: list[Node]) -> bool:
    return one in limits and nodes[one.node].op == "mul"
