"""Gradient methods of scipy on exact JAX gradients: L-BFGS-B and trust-constr."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tuner.certificate.solution import Solution
from tuner.names import unknown
from tuner.problem.problem import Problem
from tuner.solvers.multistart import Minimum, from_several


@dataclass(frozen=True)
class Gradient:
    """A gradient method with bounds, from several starts.

    Attributes:
        name: l-bfgs-b (quasi-Newton; Byrd, Lu, Nocedal, Zhu 1995) or trust-constr (Newton in a
            trust region, bounds as a barrier; its Hessian is the certificate's, central
            differences of the exact gradient).
        seed: where the random starts come from.
        starts: how many starts.
        gradient: largest component of the gradient of ln value at the end.
        iterations: limit for each start.
        curvature: whether the certificate looks at second derivatives, at the cost of two
            gradients for each parameter; without them nothing is called flat, and no parameter
            has an interval.
    """

    name: Literal["l-bfgs-b", "trust-constr"]
    seed: int
    starts: int = 4
    gradient: float = 1e-8
    iterations: int = 200
    curvature: bool = True

    def __post_init__(self) -> None:
        if self.name not in _TOLERANCE:
            raise unknown("gradient method", self.name, _TOLERANCE)

    def __call__(self, problem: Problem) -> Solution:
        """Solve a problem."""
        return from_several(
            problem,
            self.name,
            self._descend,
            starts=self.starts,
            seed=self.seed,
            smooth=True,
            curvature=self.curvature,
        )

    def _descend(self, problem: Problem, z: np.ndarray) -> Minimum:
        limits = {"gtol": self.gradient, "maxiter": self.iterations}
        return minimise(problem, z, self.name, limits, problem.space.box())


_TOLERANCE = {"l-bfgs-b": {"ftol": 1e-15}, "trust-constr": {"xtol": 1e-9}}
"""What each method calls the least progress worth going on for."""


def minimise(
    problem: Problem,
    z: np.ndarray,
    method: str,
    limits: dict[str, Any],
    box: tuple[np.ndarray, np.ndarray],
) -> Minimum:
    """One scipy descent on value / |value at the start|: its tolerances suit values near 1.

    Args:
        problem: what is minimised.
        z: the start, ``(n,)``.
        method: scipy's name of the method.
        limits: the method's options that end it, besides its least progress.
        box: lowest and highest z, ``(n,)`` each; equal where a coordinate is to stay.
    """
    from scipy.optimize import Bounds, minimize

    low, high = box
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
        options=limits | _TOLERANCE[method],
    )
    # Every Hessian costs two gradients per coordinate.
    extra = 2 * len(z) * ended.nhev if second else 0
    finished = ended.status in (1, 2) if second else bool(ended.success)
    message = str(ended.message).strip().lower().rstrip(".")
    return Minimum(ended.x, float(ended.fun * scale), ended.nfev + extra + 1, finished, message)
