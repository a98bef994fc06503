"""The solution that the ends of several descents amount to: tried, certified, and named."""

import time

import numpy as np

from tuner.certificate.certify import certify, flat, predicted_fall
from tuner.certificate.intervals import estimates
from tuner.certificate.kkt import pushed
from tuner.certificate.solution import Solution, Starts, Status
from tuner.problem.problem import Problem
from tuner.solvers.agreement import agreement, most_agree
from tuner.solvers.minimum import Descent, Minimum, best_of
from tuner.solvers.pursuit import View, gone_on, look, sharpened


def conclude(
    problem: Problem,
    solver: str,
    ends: list[Minimum],
    begun: float,
    *,
    curvature: bool = True,
    descend: Descent | None = None,
    smooth: bool = False,
) -> Solution:
    """The solution that the best of several ends amounts to.

    Where a neighbour of the best end is lower the search goes on from it; where the derivatives
    say nothing, because the objective has kinks or steps, by a simplex search.

    Args:
        problem: what is minimised.
        solver: the method's name.
        ends: where its descents ended, one at least.
        begun: when, by ``time.perf_counter``.
        curvature: whether second derivatives and neighbours are looked at.
        descend: the method itself; None where there is none that goes on.
        smooth: whether the method follows gradients alone; then Newton's step ends it.
    """
    view = look(problem, best_of(ends), curvature=curvature)
    if curvature and descend is not None:
        ends, view = gone_on(problem, descend, ends, view)
        ends, view = sharpened(problem, ends, view) if smooth else (ends, view)
    best = best_of(ends)
    starts = agreement(ends, best, view.yard)
    undetermined = flat(problem, view.yard, best.z, view.curved)
    certificate = certify(problem, best.z, view.held, view.curved, undetermined, starts)
    status = _status(problem, best, view, starts)
    return Solution(
        problem=problem.name,
        solver=solver,
        status=status,
        message=f"{status.sentence} ({best.message})",
        value=best.value,
        z=best.z,
        parameters=estimates(problem, best.z, view.yard, view.curved.hessian, undetermined),
        derived=problem.derived(best.z),
        evaluations=sum(end.evaluations for end in ends),
        seconds=time.perf_counter() - begun,
        certificate=certificate,
        gradient_by=problem.gradient_by,
    )


def _status(problem: Problem, best: Minimum, view: View, starts: Starts) -> Status:
    if not np.isfinite(best.value):
        return Status.FAILED
    if not best.allowed:
        return Status.INFEASIBLE
    alone = _status_of_point(problem, best, view)
    if alone.trusted and starts.count > 1 and not most_agree(starts):
        return Status.STARTS_DIFFER
    return alone


def _status_of_point(problem: Problem, best: Minimum, view: View) -> Status:
    """The status of a point by itself."""
    fall = predicted_fall(problem, best.z, view.held, view.curved)
    still = fall <= view.yard.negligible
    if view.near.lower is not None:
        flat = np.abs(view.held.gradient).max() <= view.yard.negligible
        falls = len(view.curved.curvatures) and view.curved.curvatures[0] < -view.yard.negligible
        return Status.SADDLE if flat and falls else _unfinished(best)
    if view.near.rough:
        return Status.STAIRCASE if view.near.steps else Status.KINK
    if np.isnan(fall):  # no derivative here, and no lower neighbour: the root of a square at 0
        return Status.KINK
    outward = pushed(problem, best.z, view.held.gradient)
    if still and (np.abs(view.held.gradient[outward]) > view.yard.negligible).any():
        return Status.AT_BOUND
    return Status.CONVERGED if still else _unfinished(best)


def _unfinished(best: Minimum) -> Status:
    return Status.STALLED if best.finished else Status.LIMIT
