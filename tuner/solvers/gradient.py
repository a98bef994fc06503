"""Gradient methods of scipy on exact JAX gradients: L-BFGS-B and trust-constr."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tuner.problem import Problem
from tuner.solution import Solution
from tuner.solvers.multistart import Minimum, from_several


@dataclass(frozen=True)
class LBFGSB:
    """Quasi-Newton with bounds (Byrd, Lu, Nocedal, Zhu 1995), from several starts.

    Attributes:
        seed: where the random starts come from.
        starts: how many starts.
        gradient: largest component of the gradient of ln value at the end.
        iterations: limit for each start.
    """

    seed: int
    starts: int = 4
    gradient: float = 1e-8
    iterations: int = 200

    name: str = "l-bfgs-b"

    def __call__(self, problem: Problem) -> Solution:
        """Solve a problem."""
        return from_several(problem, self.name, self._descend, starts=self.starts, seed=self.seed)

    def _descend(self, problem: Problem, z: np.ndarray) -> Minimum:
        options = {"gtol": self.gradient, "ftol": 1e-15, "maxiter": self.iterations}
        return _minimise(problem, z, "L-BFGS-B", options)


@dataclass(frozen=True)
class TrustConstr:
    """Newton steps in a trust region with bounds as a barrier, from several starts.

    The Hessian is that of the certificate: central differences of the exact gradient.

    Attributes:
        seed: where the random starts come from.
        starts: how many starts.
        gradient: largest component of the gradient of ln value at the end.
        iterations: limit for each start.
    """

    seed: int
    starts: int = 4
    gradient: float = 1e-8
    iterations: int = 200

    name: str = "trust-constr"

    def __call__(self, problem: Problem) -> Solution:
        """Solve a problem."""
        return from_several(problem, self.name, self._descend, starts=self.starts, seed=self.seed)

    def _descend(self, problem: Problem, z: np.ndarray) -> Minimum:
        options = {"gtol": self.gradient, "xtol": 1e-9, "maxiter": self.iterations}
        return _minimise(problem, z, "trust-constr", options)


def _minimise(problem: Problem, z: np.ndarray, method: str, options: dict[str, Any]) -> Minimum:
    """One scipy descent on value / |value at the start|: its tolerances suit values near 1."""
    from scipy.optimize import Bounds, minimize

    low, high = problem.space.box()
    begin = problem.value(z)
    scale = abs(begin)
    if not 0 < scale < np.inf:
        return Minimum(z, begin, 1, False, "the objective at the start is not usable")

    def value_and_gradient(point: np.ndarray) -> tuple[float, np.ndarray]:
        value, gradient = problem.value_and_gradient(point)
        return value / scale, gradient / scale

    second = method == "trust-constr"
    ended = minimize(
        value_and_gradient,
        np.clip(z, low, high),
        jac=True,
        hess=(lambda point: problem.hessian(point) / scale) if second else None,
        method=method,
        bounds=Bounds(low, high),
        options=options,
    )
    # Every Hessian costs two gradients per coordinate.
    extra = 2 * len(z) * ended.nhev if second else 0
    finished = ended.status in (1, 2) if second else bool(ended.success)
    message = str(ended.message).strip().lower().rstrip(".")
    return Minimum(ended.x, float(ended.fun * scale), ended.nfev + extra + 1, finished, message)
