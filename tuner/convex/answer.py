"""The answer of a convex program."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.certificate.solution import Status

Report: TypeAlias = Callable[["Answer"], dict[str, float]]
"""From an answer to derived numbers."""


@dataclass(frozen=True)
class Answer:
    """The answer of a convex program.

    Attributes:
        status: how it ended.
        message: that, in a sentence.
        value: the objective at the point; nan where there is none, -inf where it is unbounded and
            inf where nothing is admissible.
        variables: the point, by name; empty where there is none.
        duals: dual variables of the named constraints, signed as cvxpy does: not negative for an
            inequality, positive semidefinite for a matrix inequality.
        multipliers: by constraint with a constant side, by how many per cent the value falls
            where that side is 1 % wider (an equality: 1 % larger).
        lower_bound: no admissible point has a lower value, as the dual solution proves. The
            rounding left in it is allowed for, for all points whose coordinates in the solver's
            form are up to :data:`tuner.convex.MARGIN` times those of the solution. None where it
            proves nothing.
        gap: value less lower bound; inf without a bound.
        violation: the largest violation of a constraint at the point, over one plus the size of
            the constraint's terms; computed from the variables, not taken from the solver.
        iterations: of the solver, over all its runs.
        seconds: total time.
    """

    status: Status
    message: str
    value: float
    variables: dict[str, np.ndarray]
    duals: dict[str, np.ndarray]
    multipliers: dict[str, float]
    lower_bound: float | None
    gap: float
    violation: float
    iterations: int
    seconds: float
