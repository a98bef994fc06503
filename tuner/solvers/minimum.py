"""Where one descent ends, and what a descent is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.problem.constraint import ALLOWED
from tuner.problem.problem import Problem


@dataclass(frozen=True)
class Minimum:
    """Where one descent ended.

    Attributes:
        z: the point, ``(n,)``.
        value: the objective there.
        evaluations: how often it was evaluated.
        finished: whether the method's own tolerance ended it, not a limit.
        message: the method's own words.
        excess: how far the worst constraint is exceeded, as a share of its bound.
        blocked: whether no step was lower although the slope had not vanished, as at a jump.
    """

    z: np.ndarray
    value: float
    evaluations: int
    finished: bool
    message: str
    excess: float = -np.inf
    blocked: bool = False

    @property
    def allowed(self) -> bool:
        """Whether it keeps every constraint."""
        return self.excess <= ALLOWED


Descent: TypeAlias = Callable[[Problem, np.ndarray], Minimum]
"""From a problem and one start ``(n,)`` to where it leads."""


def best_of(ends: list[Minimum]) -> Minimum:
    """The end with the lowest value among those that keep every constraint, if any do."""
    return min(ends, key=lambda end: (not end.allowed, end.value))
