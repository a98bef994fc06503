"""Gradients for what is smooth and a simplex search for thresholds, in turn."""

from dataclasses import dataclass, field, replace

import numpy as np

from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.solvers.gradient import minimise
from tuner.solvers.minimum import Minimum
from tuner.solvers.multistart import from_several, refuse
from tuner.solvers.simplex import boxed
from tuner.solvers.starts import SharedStarts


@dataclass(frozen=True)
class Alternating:
    """L-BFGS-B with the thresholds held, then Nelder-Mead on the thresholds alone, and again.

    Each turn can only lower the value. Without thresholds it is L-BFGS-B alone. The certificate
    speaks of the smooth coordinates.

    Attributes:
        seed: where the random starts come from.
        starts: how many starts.
        rounds: limit of turns for each start.
        progress: a turn that lowers the value by less than this share is the last.
        step: edge of the first simplex in z; 0.5 is a factor of 1.65.
        gradient: largest component of the gradient of ln value at the end of a descent.
        iterations: limit of each descent.
        shared: where other processes make some of the descents; None: all are made here.
    """

    seed: int
    starts: int = 4
    rounds: int = 10
    progress: float = 1e-6
    step: float = 0.5
    gradient: float = 1e-8
    iterations: int = 200
    shared: SharedStarts | None = field(default=None, repr=False)

    name: str = "alternating"

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
        found = self._smooth(problem, z)
        count = found.evaluations
        for _ in range(self.rounds if problem.space.thresholds().any() else 0):
            switched = self._switch(problem, found.z)
            again = self._smooth(problem, switched.z)
            count += switched.evaluations + again.evaluations
            lowered = found.value - again.value
            found = again if lowered > 0 else found
            if lowered <= self.progress * abs(found.value):
                break
        return replace(found, evaluations=count)

    def _smooth(self, problem: Problem, z: np.ndarray) -> Minimum:
        steps = problem.space.thresholds()
        if steps.all():
            return Minimum(z, problem.value(z), 1, True, "nothing is smooth")
        low, high = (np.where(steps, z, end) for end in problem.space.box())
        limits = {"gtol": self.gradient, "maxiter": self.iterations}
        return minimise(problem, z, "l-bfgs-b", limits, (low, high))

    def _switch(self, problem: Problem, z: np.ndarray) -> Minimum:
        """The best thresholds beside the other coordinates of z."""
        steps = problem.space.thresholds()
        low, high = (end[steps] for end in problem.space.box())

        def whole(part: np.ndarray) -> np.ndarray:
            point = z.copy()
            point[steps] = part
            return point

        found = boxed(
            lambda part: problem.value(whole(part)),
            z[steps],
            (low, high),
            step=self.step,
            tolerance=1e-3,
            limit=100 * len(low),
        )
        return replace(found, z=whole(found.z))
