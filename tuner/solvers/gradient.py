"""Gradient methods of scipy on exact JAX gradients: L-BFGS-B and trust-constr."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

import numpy as np

from objectives import kind_of
from tuner.certificate.solution import Solution
from tuner.names import unknown
from tuner.problem.problem import Problem
from tuner.solvers.minimum import Minimum
from tuner.solvers.multistart import from_several, refuse
from tuner.solvers.rounding import OnlyRoundingError, UntilRounding
from tuner.solvers.starts import SharedStarts


@dataclass(frozen=True)
class Gradient:
    """A gradient method with bounds, from several starts.

    Attributes:
        name: l-bfgs-b (quasi-Newton; Byrd, Lu, Nocedal, Zhu 1995) or trust-constr (Newton in a
            trust region, bounds as a barrier; its Hessian is the certificate's, central
            differences of the exact gradient).
        seed: where the random starts come from.
        starts: how many starts.
        gradient: largest component of the gradient at the end, over the value; a likelihood's over
            1 nat a number.
        iterations: limit for each start.
        curvature: whether the certificate looks at second derivatives, at the cost of two
            gradients for each parameter; without them nothing is called flat, and no parameter
            has an interval.
        shared: where other processes make some of the descents; None: all are made here.
    """

    name: Literal["l-bfgs-b", "trust-constr"]
    seed: int
    starts: int = 4
    gradient: float = 1e-8
    iterations: int = 200
    curvature: bool = True
    shared: SharedStarts | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if self.name not in _TOLERANCE:
            raise unknown("gradient method", self.name, _TOLERANCE)

    def help(self, problem: Problem) -> int:
        """Make those descents of a shared search that nobody has begun; returns how many."""
        if self.shared is None:
            return 0
        return self.shared.help(problem, self._descend, self.starts, self.seed)

    def check(self, problem: Problem) -> None:
        """Refuse what cannot begin; see :func:`tuner.solvers.multistart.refuse`."""
        refuse(problem, self.name, self.starts, "start", smooth=True)

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
            shared=self.shared,
        )

    def _descend(self, problem: Problem, z: np.ndarray) -> Minimum:
        limits = {"gtol": self.gradient, "maxiter": self.iterations}
        return minimise(problem, z, self.name, limits, problem.space.box())


Evaluate: TypeAlias = Callable[[np.ndarray], tuple[float, np.ndarray]]
"""An objective and its gradient at z ``(n,)``."""
_TOLERANCE = {"l-bfgs-b": {"ftol": 1e-15}, "trust-constr": {"xtol": 1e-9}}
"""Each method's name for the least progress worth another iteration."""


SCALES = 8
"""A descent that falls by orders of magnitude is begun again with its new scale, so often."""
RESCALED = 0.1
"""A value below this share of the scale is worth that."""


def minimise(
    problem: Problem,
    z: np.ndarray,
    method: str,
    limits: dict[str, Any],
    box: tuple[np.ndarray, np.ndarray],
) -> Minimum:
    """A scipy descent on value / scale, so that its tolerances mean what they say.

    The scale is |value at the start|, and again where the descent ended far below it; a
    likelihood, of which differences count and not ratios, has 1 nat a number at least.

    Args:
        problem: what is minimised.
        z: the start, ``(n,)``.
        method: scipy's name of the method.
        limits: the method's options that end it, besides its least progress.
        box: lowest and highest z, ``(n,)`` each; equal where a coordinate is to stay.
    """
    begin, least = problem.value(z), 1.0 if kind_of(problem.objective) == "likelihood" else 0.0
    end = Minimum(z, begin, 1, False, "the objective at the start is not usable")
    if not np.isfinite(begin):
        return end
    scale = max(abs(begin), least) or 1.0
    for _ in range(SCALES):
        found = _once(problem, end.z, method, limits, box, scale)
        end = replace(found, evaluations=end.evaluations + found.evaluations)
        smaller = max(abs(end.value), least)
        if not 0 < smaller < RESCALED * scale:
            break
        scale = smaller
    return end


def _once(
    problem: Problem,
    z: np.ndarray,
    method: str,
    limits: dict[str, Any],
    box: tuple[np.ndarray, np.ndarray],
    scale: float,
) -> Minimum:
    descend = _in_trust_region if method == "trust-constr" else _quasi_newton
    return descend(problem, np.clip(z, *box), limits, box, scale)


def _quasi_newton(
    problem: Problem,
    z: np.ndarray,
    limits: dict[str, Any],
    box: tuple[np.ndarray, np.ndarray],
    scale: float,
) -> Minimum:
    # scipy.optimize.minimize would convert the bounds three times, which takes as long as several
    # evaluations of a short record.
    from scipy.optimize import fmin_l_bfgs_b

    scaled = _Scaled(UntilRounding(problem, box), scale)
    try:
        z, value, told = fmin_l_bfgs_b(
            scaled.value,
            z,
            scaled.gradient,
            bounds=np.stack(box, axis=1),
            factr=_TOLERANCE["l-bfgs-b"]["ftol"] / np.finfo(float).eps,
            pgtol=limits["gtol"],
            maxiter=limits["maxiter"],
        )
    except OnlyRoundingError as error:
        return error.end
    status, message = told["warnflag"], _words(told["task"])
    end = Minimum(z, float(value * scale), told["funcalls"], status != 1, message)
    if status != 2:
        return end
    # L-BFGS-B gives the last point tried then, be it ever so high.
    lowest, at = scaled.lowest
    return replace(end, z=at, value=lowest, blocked=True)


def _in_trust_region(
    problem: Problem,
    z: np.ndarray,
    limits: dict[str, Any],
    box: tuple[np.ndarray, np.ndarray],
    scale: float,
) -> Minimum:
    from scipy.optimize import Bounds, minimize

    scaled = _Scaled(problem.value_and_gradient, scale)
    ended = minimize(
        scaled.value,
        z,
        jac=scaled.gradient,
        hess=lambda point: problem.hessian(point) / scale,
        method="trust-constr",
        bounds=Bounds(*box),
        options=limits | _TOLERANCE["trust-constr"],
    )
    # Every Hessian costs two gradients per coordinate.
    evaluations = ended.nfev + 2 * len(z) * ended.nhev
    finished, message = ended.status in (1, 2), _words(ended.message)
    return Minimum(ended.x, float(ended.fun * scale), evaluations, finished, message)


def _words(message: Any) -> str:
    return str(message).strip().lower().rstrip(".")


class _Scaled:
    """An objective over its scale, whose gradient comes with its value: each point is asked once.

    Args:
        evaluate: the objective and its gradient at z ``(n,)``.
        scale: what both are divided by.

    Attributes:
        lowest: the lowest value, not scaled, and its z.
    """

    def __init__(self, evaluate: Evaluate, scale: float) -> None:
        self._evaluate, self._scale = evaluate, scale
        self._at, self._gradient = b"", np.empty(0)
        self.lowest: tuple[float, np.ndarray] = np.inf, np.empty(0)

    def value(self, z: np.ndarray) -> float:
        """The value at z ``(n,)``."""
        value, gradient = self._evaluate(z)
        self._at, self._gradient = z.tobytes(), gradient / self._scale
        if value < self.lowest[0]:
            self.lowest = value, z.copy()
        return value / self._scale

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """The gradient at z ``(n,)``, for which the value is mostly asked first."""
        if z.tobytes() != self._at:
            self.value(z)
        return self._gradient
