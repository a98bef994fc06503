"""Constants of a long step that show together, though none does alone.

C with loops has one number where the formulas have many: a change of it moves what all of them
move.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from tuner.code.array_step import Step
from tuner.code.mutants import Mutant
from tuner.code.states import Arrays

_APART = 64
"""Nodes between equal constants from which they belong to different operations on arrays."""
_LEAST = 2.0
"""The move of equal constants together, over its tolerance, that is worth a step."""


class Together:
    """The steps in which equal constants of equal operations move most.

    Args:
        step: whose constants they are.
    """

    def __init__(self, step: Step) -> None:
        self._group = dict[Mutant, int]()
        last = dict[tuple[str, int, float], Mutant]()
        for one in step.mutants:
            node = step.graph.nodes[one.node]
            key = node.op, one.at, float(step.graph.nodes[node.args[one.at]].value)
            before = last.get(key)
            apart = before is None or one.node - before.node > _APART
            self._group[one] = len(self._group) if apart else self._group[last[key]]
            last[key] = one
        self._best = dict[int, tuple[float, Arrays]]()
        self._looked = dict[int, np.ndarray]()

    def look(self, moves: Mapping[Mutant, np.ndarray]) -> None:
        """Sum up moves of constants in steps, ``(B,)`` each, of which none is large."""
        self._looked = {}
        for one, size in moves.items():
            group = self._group[one]
            self._looked[group] = self._looked.get(group, 0.0) + size**2

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
