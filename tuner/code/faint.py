"""Constants that move results hardly further than is allowed."""

from collections.abc import Iterable, Mapping

import numpy as np

from tuner.code.mutants import Mutant
from tuner.code.states import Arrays

_LEAST, _KEPT = 0.7, 6
"""The move over its tolerance that is kept, and how many steps of a constant: the tolerance follows
from random errors, so that another one may let the move pass."""


class Faint:
    """The steps in which constants that do not show for sure move a result most."""

    def __init__(self) -> None:
        self._best = dict[Mutant, list[tuple[float, Arrays]]]()

    def look(self, moves: Mapping[Mutant, np.ndarray], steps: Arrays) -> None:
        """Keep those of these steps, a field each, that are among the best.

        Args:
            moves: the largest of a result over its tolerance, ``(B,)`` each.
            steps: in which they are.
        """
        for one, sizes in moves.items():
            large = np.flatnonzero(sizes >= _LEAST)
            some = [(float(sizes[at]), [x[at] for x in steps]) for at in large]
            best = [*self._best.get(one, ()), *some]
            if best:
                self._best[one] = sorted(best, key=lambda one: -one[0])[:_KEPT]

    def leave(self, hidden: Iterable[Mutant]) -> None:
        """Only constants that are still hidden remain."""
        self._best = {one: self._best[one] for one in hidden if one in self._best}

    @property
    def mutants(self) -> list[Mutant]:
        """The constants."""
        return list(self._best)

    @property
    def steps(self) -> list[Arrays]:
        """The steps of all of them."""
        return [step for best in self._best.values() for _, step in best]
