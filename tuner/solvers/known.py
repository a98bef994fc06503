"""Solutions known from elsewhere, judged like any other."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.solvers.conclude import conclude
from tuner.solvers.minimum import Minimum


@dataclass(frozen=True)
class Known:
    """A closed form or an equation's solution in place of a search.

    It gets the certificate of any other solution: a wrong formula ends as stalled or infeasible.

    Attributes:
        name: what it is called, "closed form".
        find: from a problem to the parameters by name; those left out keep their initial value.
        words: where it comes from.
    """

    name: str
    find: Callable[[Problem], Mapping[str, float | np.ndarray]]
    words: str

    def __call__(self, problem: Problem) -> Solution:
        """Judge it."""
        begun = time.perf_counter()
        z = problem.space.unconstrain(self.find(problem))
        excess = float(problem.excesses(z)[0].max(initial=-np.inf))
        end = Minimum(z, problem.value(z), 1, True, self.words, excess)
        return conclude(problem, self.name, [end], begun)
