"""Constants of a long step whose numbers in C are not those of the formulas.

C with loops has one number where the formulas have many: a change of it moves what all of them
move. And it divides by a number where the formulas multiply by its inverse, which becomes smaller
where the number becomes larger.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from tuner.code.array_step import Step
from tuner.code.detection import EPS, Expected, detected
from tuner.code.mutants import CHANGE, WHOLE, Mutant
from tuner.code.nodes import Node
from tuner.code.states import Arrays

_APART = 64
"""Nodes between equal constants from which they belong to different operations on arrays."""
_LEAST = 2.0
"""The move of equal constants together, over its tolerance, that is worth a step."""

_PART = 96
"""Factors that are changed together: what depends on none of them is not worked out."""


class Together:
    """The steps in which equal constants of equal operations move most.

    Args:
        step: whose constants they are.

    Attributes:
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
        self.whole = self._halved()
        self._constantless = {*self.whole.values()} - {*self._group.values()}
        # What is zero but for rounding, as those sums are, was evaluated in double.
        self._rounding = EPS[step.program.precision] / EPS["double"]
        self._best = dict[int, tuple[float, Arrays]]()
        self._looked = dict[int, np.ndarray]()

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
        self._looked = {}
        hidden = {self._group[one] for one in moves if one.at != WHOLE}
        for one, size in moves.items():
            if one.at == WHOLE and self.whole[one.node] not in hidden | self._constantless:
                continue
            group = self.whole[one.node] if one.at == WHOLE else self._group[one]
            moved = size * self._rounding if one.at == WHOLE else size
            self._looked[group] = self._looked.get(group, 0.0) + moved**2

    def take(self, steps: Arrays) -> None:
        """Keep those of these steps, a field each, that are the best so far."""
        for group, squares in self._looked.items():
            at = int(np.argmax(squares))
            size = float(np.sqrt(squares[at]))
            if size >= _LEAST and size > self._best.get(group, (0.0, []))[0]:
                self._best[group] = size, [x[at] for x in steps]

    def steps(self) -> Iterator[Arrays]:
        """The best steps, that of the largest moves first."""
        for _, steps in sorted(self._best.values(), key=lambda one: -one[0]):
            yield steps


class Inverses:
    """The steps in which factors that only decide show when they become smaller.

    Args:
        step: whose constants they are.
    """

    def __init__(self, step: Step) -> None:
        nodes = step.graph.nodes
        self._step = step
        self._factors = [one for one in step.mutants if _is_factor(one, step.limits, nodes)]
        self._found = list[Arrays]()

    def look(self, right: Expected, steps: Arrays) -> None:
        """Keep those of these steps, a field each, that show a factor that none did before."""
        if not self._factors:
            return
        parts = [self._factors[at : at + _PART] for at in range(0, len(self._factors), _PART)]
        found = [detected(self._step, part, right, 2.0, change=-CHANGE) for part in parts]
        shows = np.concatenate(found)
        some = np.asarray(shows.any(axis=1))
        self._found += [[x[at] for x in steps] for at in sorted({*shows[some].argmax(axis=1)})]
        self._factors = [one for one, seen in zip(self._factors, some, strict=True) if not seen]

    def steps(self) -> list[Arrays]:
        """The steps."""
        return self._found


def _is_factor(one: Mutant, limits: set[Mutant], nodes: list[Node]) -> bool:
    return one in limits and nodes[one.node].op == "mul"
