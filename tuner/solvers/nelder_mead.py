"""Nelder and Mead's simplex search from several starts."""

from dataclasses import dataclass, field

import numpy as np

from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.solvers.minimum import Minimum
from tuner.solvers.multistart import from_several, refuse
from tuner.solvers.simplex import boxed
from tuner.solvers.starts import SharedStarts


@dataclass(frozen=True)
class NelderMead:
    """Simplex search from several starts: needs no gradient, copes with thresholds.

    In z, where positive parameters are logarithms, fminsearch's start (5 % of each coordinate)
    would depend on the unit, so the first simplex takes a fixed step along each coordinate.

    Attributes:
        seed: where the random starts come from.
        starts: how many starts.
        step: edge of the first simplex in z; 0.5 is a factor of 1.65.
        tolerance: size of the last simplex in z.
        evaluations: limit for each start, per parameter.
        shared: where other processes make some of the descents; None: all are made here.
    """

    seed: int
    starts: int = 4
    step: float = 0.5
    tolerance: float = 1e-5
    evaluations: int = 400
    shared: SharedStarts | None = field(default=None, repr=False)

    name: str = "nelder-mead"

    def help(self, problem: Problem) -> int:
        """Make those descents of a shared search that nobody has begun; returns how many."""
        if self.shared is None:
            return 0
        return self.shared.help(problem, self._descend, self.starts, self.seed)

    def check(self, problem: Problem) -> None:
        """Refuse what cannot begin; see :func:`tuner.solvers.multistart.refuse`."""
        refuse(problem, self.name, self.starts, "start")

    def __call__(self, problem: Problem) -> Solution:
        """Solve a problem."""
        return from_several(
            problem,
            self.name,
            self._descend,
            starts=self.starts,
            seed=self.seed,
            shared=self.shared,
        )

    def _descend(self, problem: Problem, z: np.ndarray) -> Minimum:
        box, limit = problem.space.box(), self.evaluations * len(z)
        return boxed(problem.value, z, box, step=self.step, tolerance=self.tolerance, limit=limit)
