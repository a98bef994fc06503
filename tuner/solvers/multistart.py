"""What all solvers share: several starts, the best end, its certificate and its status."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.certify import certify, estimates, is_stationary, spectrum
from tuner.problem import Problem
from tuner.solution import Certificate, Solution, Starts, Status


@dataclass(frozen=True)
class Minimum:
    """Where one descent ended.

    Attributes:
        z: the point, ``(n,)``.
        value: the objective there.
        evaluations: how often it was evaluated.
        finished: whether the method's own tolerance ended it, not a limit.
        message: the method's own words.
    """

    z: np.ndarray
    value: float
    evaluations: int
    finished: bool
    message: str


Descent: TypeAlias = Callable[[Problem, np.ndarray], Minimum]
"""From a problem and one start ``(n,)`` to where it leads."""


def from_several(
    problem: Problem, solver: str, descend: Descent, *, starts: int, seed: int
) -> Solution:
    """Descend from the initial point and from random points of the box; certify the best end.

    Args:
        problem: what is minimised.
        solver: the method's name.
        descend: one descent from one start.
        starts: how many starts, the initial point among them.
        seed: where the random starts come from.

    Raises:
        ValueError: for fewer than one start, or where nothing is free.
    """
    refuse_idle(problem, solver, starts, "start")
    begun = time.perf_counter()
    ends = [descend(problem, z) for z in problem.space.starts(starts, seed)]
    return conclude(problem, solver, ends, time.perf_counter() - begun)


def refuse_idle(problem: Problem, solver: str, count: int, what: str) -> None:
    """Refuse to begin without a start or trial, or where nothing is free.

    Raises:
        ValueError: says which of the two.
    """
    if count < 1:
        raise ValueError(f"{solver} needs at least one {what}, got {count}")
    if problem.space.size == 0:
        raise ValueError(f"every parameter of {problem.name} is fixed: there is nothing to tune")


def conclude(problem: Problem, solver: str, ends: list[Minimum], seconds: float) -> Solution:
    """The solution that the best of several ends amounts to."""
    best = min(ends, key=lambda end: end.value)
    curved = spectrum(problem, best.z)
    certificate = certify(problem, best.z, curved, _agreement(ends, best))
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


def _agreement(ends: list[Minimum], best: Minimum) -> Starts:
    scale = abs(best.value) or 1.0
    excess = [(end.value - best.value) / scale for end in ends]
    return Starts(len(ends), sum(e < 1e-3 for e in excess), 1 + max(excess))


def _status(problem: Problem, best: Minimum, certificate: Certificate) -> Status:
    if not np.isfinite(best.value):
        return Status.FAILED
    free, bounded = is_stationary(problem, best.z, certificate.gradient)
    if free:
        return Status.CONVERGED
    if bounded:
        return Status.AT_BOUND
    return Status.STALLED if best.finished else Status.LIMIT
