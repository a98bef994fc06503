"""Several starts, the best end, its certificate and its status, for all solvers."""

import os
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tuner.certificate.solution import Solution
from tuner.limits import memory
from tuner.problem.problem import Problem
from tuner.solvers.blas import blas_on_one_thread
from tuner.solvers.conclude import conclude
from tuner.solvers.minimum import Descent, Minimum
from tuner.solvers.side_by_side import descents
from tuner.solvers.starts import REDRAWN, SharedStarts

TRANSFORMED = 12
"""About how many copies of what a run keeps exist while its objective is computed."""


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
    shared: SharedStarts | None = None,
    threads: int | None = None,
) -> Solution:
    """Descend from the initial point and from the problem's others; certify the best end.

    The descents run side by side in threads, where one takes long enough and memory allows.

    Args:
        problem: what is minimised.
        solver: the method's name.
        descend: one descent from one start.
        starts: how many starts, the initial point among them.
        seed: where the random starts come from.
        constrained: whether the method keeps constraints.
        smooth: whether the method follows gradients alone.
        curvature: whether the certificate looks at second derivatives.
        shared: where other processes make some of the descents; None: all are made here.
        threads: how many descents run at the same time; None: as many as there are processors.

    Raises:
        ValueError: for fewer than one start, where nothing is free, where there are constraints
            and the solver takes none, or thresholds and it follows gradients.
    """
    refuse(problem, solver, starts, "start", constrained=constrained, smooth=smooth)
    begun = time.perf_counter()
    with blas_on_one_thread():
        if shared is None:
            points = problem.starts(starts + REDRAWN, seed)
            made = descents(problem, descend, points, starts, threads or _threads(problem))
        else:
            made = shared.ends(problem, descend, starts, seed)
        return conclude(
            problem,
            solver,
            _finite(made, starts),
            begun,
            curvature=curvature,
            descend=descend,
            smooth=smooth,
        )


def _threads(problem: Problem) -> int:
    """One for each processor, where memory allows."""
    held = TRANSFORMED * problem.kept_bytes
    return min(os.cpu_count() or 1, max(1, memory() // 4 // max(held, 1)))


def _finite(made: Iterator[Minimum], count: int) -> list[Minimum]:
    """So many ends; those that are not a number are lost, and others are drawn in their place."""
    ends: list[Minimum] = []
    lost: list[Minimum] = []
    for end in made:
        (ends if np.isfinite(end.value) else lost).append(end)
        if len(ends) == count:
            break
    wasted = sum(end.evaluations for end in lost)
    first, *others = ends or lost[:1]
    total = first.evaluations + wasted if ends else wasted
    return [replace(first, evaluations=total), *others]


def refuse(
    problem: Problem,
    solver: str,
    count: int,
    what: str,
    *,
    constrained: bool = False,
    smooth: bool = False,
) -> None:
    """Refuse what cannot begin.

    Raises:
        ValueError: for no start or trial, nothing free, constraints that nobody would keep, and
            thresholds where gradients are followed; says which.
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
    steps = problem.space.thresholds()
    if smooth and steps.any():
        names = np.array(problem.space.coordinates)[steps]
        raise ValueError(
            f"{solver} follows gradients, and {problem.name} is piecewise constant in "
            f"{', '.join(name.removeprefix('ln ') for name in names)}; fix it, or solve by "
            "alternating, nelder-mead, cma-es or tpe"
        )
