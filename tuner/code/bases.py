"""Steps that are to be brought to a limit, and how far they are from it."""

from dataclasses import dataclass

import numpy as np

from tuner.code.array_step import Step
from tuner.code.compared import Compared, ComparedNumbers
from tuner.code.states import Arrays, by_node

_BEYOND = 1e-3
"""Distance from a limit, over it, from which a step is well beyond."""
_PASSED = 1e-30
"""Share of a distance that counts behind the limit."""


@dataclass(frozen=True, eq=False)
class Bases:
    """Steps that are to be brought to a limit.

    Attributes:
        compared: at which decision, of each step.
        steps: states and samples, a field each.
        numbers: those that are compared.
    """

    compared: list[Compared]
    steps: Arrays
    numbers: ComparedNumbers

    def of(self, which: np.ndarray) -> "Bases":
        """Some of them."""
        compared = [self.compared[k] for k in which]
        return Bases(compared, [x[which] for x in self.steps], self.numbers)


def above(step: Step, own: int, steps: Arrays, bases: Bases) -> np.ndarray:
    """The number that is compared, its limit, and whether its outcome may matter, ``(3, count)``.

    In as many steps for each base.

    Args:
        step: the filter's.
        own: number of fields of the state.
        steps: those of the first base, then those of the next.
        bases: what is compared.
    """
    given = by_node(step.program, steps[:own], steps[own:])
    return bases.numbers.in_own_steps(given, bases.compared)


def missing(
    step: Step, own: int, steps: Arrays, bases: Bases, side: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How much is missing to be well beyond the limit, and how far a step is before it.

    Before the limit the former is the distance, so that a step comes closer to what it cannot pass;
    behind it, less than that of any step before it. It has no end where the outcome does not matter
    any more, since something else is decided otherwise.

    Args:
        step: the filter's.
        own: number of fields of the state.
        steps: those of the first base, then those of the next.
        bases: what is compared.
        side: 1 for steps that begin above the limit, -1 for the others.
    """
    x, limit, matters = above(step, own, steps, bases)
    with np.errstate(all="ignore"):
        apart = side * (x - limit)
        rest = _PASSED * np.maximum(apart + _BEYOND * np.abs(limit), 0)
    gap = np.where(apart > 0, apart, np.where(apart < 0, rest, _PASSED))
    return np.where(np.isfinite(gap) & (matters > 0), gap, np.inf), apart
