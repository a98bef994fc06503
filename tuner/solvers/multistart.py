"""What all solvers share: several starts, the best end, its certificate and its status."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.certificate.certify import certify, estimates, is_stationary, spectrum, unknown_spectrum
from tuner.certificate.kkt import hold
from tuner.certificate.solution import Certificate, Solution, Starts, Status
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
    """

    z: np.ndarray
    value: float
    evaluations: int
    finished: bool
    message: str
    excess: float = -np.inf

    @property
    def allowed(self) -> bool:
        """Whether it keeps every constraint."""
        return self.excess <= ALLOWED


Descent: TypeAlias = Callable[[Problem, np.ndarray], Minimum]
"""From a problem and one start ``(n,)`` to where it leads."""


def from_several(
    problem: Problem,
    solver: str,
    descend: Descent,
    *,
    starts: int,
    seed: int,
    constrained: bool = False,
    smooth: bool = False,
    curvature: bool = True,
) -> Solution:
    """Descend from the initial point and from the problem's others; certify the best end.

    Args:
        problem: what is minimised.
        solver: the method's name.
        descend: one descent from one start.
        starts: how many starts, the initial point among them.
        seed: where the random starts come from.
        constrained: whether the method keeps constraints.
        smooth: whether the method follows gradients alone.
        curvature: whether the certificate looks at second derivatives.

    Raises:
        ValueError: for fewer than one start, where nothing is free, where there are constraints
            and the solver takes none, or thresholds and it follows gradients.
    """
    refuse(problem, solver, starts, "start", constrained=constrained)
    steps = problem.space.thresholds()
    if smooth and steps.any():
        names = np.array(problem.space.coordinates)[steps]
        raise ValueError(
            f"{solver} follows gradients, and {problem.name} is piecewise constant in "
            f"{', '.join(name.removeprefix('ln ') for name in names)}, whose gradient is 0 and "
            "says nothing; fix it, or solve by alternating, nelder-mead, cma-es or tpe"
        )
    begun = time.perf_counter()
    ends = [descend(problem, z) for z in problem.starts(starts, seed)]
    return conclude(problem, solver, ends, time.perf_counter() - begun, curvature=curvature)


def refuse(
    problem: Problem, solver: str, count: int, what: str, *, constrained: bool = False
) -> None:
    """Refuse what cannot begin: no start or trial, nothing free, constraints nobody would keep.

    Raises:
        ValueError: says which of the three.
    """
    if count < 1:
        raise ValueError(f"{solver} needs at least one {what}, got {count}")
    if problem.space.size == 0:
        raise ValueError(f"every parameter of {problem.name} is fixed: there is nothing to tune")
    if problem.constraints and not constrained:
        names = ", ".join(constraint.name for constraint in problem.constraints)
        raise ValueError(
            f"{solver} keeps no constraints, and {problem.name} has {names}: solve it by ipopt"
        )


def conclude(
    problem: Problem,
    solver: str,
    ends: list[Minimum],
    seconds: float,
    *,
    curvature: bool = True,
) -> Solution:
    """The solution that the best of several ends amounts to."""
    best = best_of(ends)
    held = hold(problem, best.z)
    curved = spectrum(problem, best.z, held) if curvature else unknown_spectrum(problem.space.size)
    certificate = certify(problem, best.z, held, curved, _agreement(ends, best))
    status = _status(problem, best, certificate)
    return Solution(
        problem=problem.name,
        solver=solver,
        status=status,
        message=f"{status.sentence} ({best.message})",
        value=best.value,
        z=best.z,
        parameters=estimates(problem, best.z, curved),
        derived=problem.derived(best.z),
        evaluations=sum(end.evaluations for end in ends),
        seconds=seconds,
        certificate=certificate,
    )


def best_of(ends: list[Minimum]) -> Minimum:
    """The end with the lowest value among those that keep every constraint, if any do."""
    return min(ends, key=lambda end: (not end.allowed, end.value))


def _agreement(ends: list[Minimum], best: Minimum) -> Starts:
    scale = abs(best.value) or 1.0
    excess = [(end.value - best.value) / scale if end.allowed else np.inf for end in ends]
    return Starts(len(ends), sum(e < 1e-3 for e in excess), 1 + max(excess))


def _status(problem: Problem, best: Minimum, certificate: Certificate) -> Status:
    if not np.isfinite(best.value):
        return Status.FAILED
    if not best.allowed:
        return Status.INFEASIBLE
    free, bounded = is_stationary(problem, best.z, certificate.gradient)
    if free:
        return Status.CONVERGED
    if bounded:
        return Status.AT_BOUND
    return Status.STALLED if best.finished else Status.LIMIT
