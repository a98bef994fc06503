"""The solution that the ends of several descents amount to: tried, certified, and named."""

import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tuner.certificate.certify import certify, flat, predicted_fall
from tuner.certificate.intervals import estimates
from tuner.certificate.kkt import Held, hold, pushed
from tuner.certificate.neighbours import Neighbours, lower_afar, neighbours
from tuner.certificate.solution import Solution, Starts, Status
from tuner.certificate.spectrum import Spectrum, spectrum, unknown_spectrum
from tuner.certificate.yardstick import Yardstick, yardstick
from tuner.problem.problem import Problem
from tuner.solvers.minimum import Descent, Minimum, best_of
from tuner.solvers.simplex import boxed

ROUNDS = 4
"""How often a search goes on from a lower neighbour of its end."""
AGREE = {"likelihood": 0.05}
"""Ends that differ by less, in nats, agree; of any other kind by 0.1 % of the value."""


class _View(NamedTuple):
    """A point looked at: how values are measured there, what holds it, curvature, neighbours."""

    yard: Yardstick
    held: Held
    curved: Spectrum
    near: Neighbours


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
    view = _look(problem, best_of(ends), curvature=curvature)
    if curvature and descend is not None:
        ends, view = _gone_on(problem, descend, ends, view)
        ends, view = _sharpened(problem, ends, view) if smooth else (ends, view)
    best = best_of(ends)
    starts = _agreement(ends, best, view.yard)
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
    )


def _look(problem: Problem, end: Minimum, *, curvature: bool) -> _View:
    yard = yardstick(problem, end.z)
    held = hold(problem, end.z, yard.unit)
    if not curvature or not np.isfinite(end.value):
        return _View(yard, held, unknown_spectrum(len(end.z)), Neighbours(None, False, False, 0))
    curved = spectrum(problem, yard, end.z, held)
    return _View(yard, held, curved, neighbours(problem, yard, end.z, held, curved))


def _gone_on(
    problem: Problem, descend: Descent, ends: list[Minimum], view: _View
) -> tuple[list[Minimum], _View]:
    """The ends, gone on with while lower points are seen; and the best one's view.

    It may cost as many evaluations as the search itself.
    """
    most = 2 * _spent(ends)
    for turn in range(ROUNDS):
        best, lower = best_of(ends), view.near.lower
        # What a second descent did not find either, the derivatives do not show.
        rough = (view.near.rough and turn == 0) or (lower is not None and turn == 1)
        if not (best.allowed and best.finished) or not (rough or lower is not None):
            break
        if lower is not None:
            ends = [_followed(problem, descend, e, lower) if e is best else e for e in ends]
        if rough and not problem.constraints:
            ends = [_simplex(problem, end) for end in ends]
        view = _look(problem, best_of(ends), curvature=True)
        if _spent(ends) > most:
            return ends, view
    best = best_of(ends)
    for i in sorted(range(len(ends)), key=lambda i: ends[i].value):
        lowest = best_of(ends)
        alone = ends[i] is lowest and not _most_agree(_agreement(ends, lowest, view.yard))
        if alone or not _agrees(ends[i], lowest, view.yard):
            ends = [*ends[:i], _from_afar(problem, descend, ends, i, most), *ends[i + 1 :]]
    if best_of(ends) is not best:
        view = _look(problem, best_of(ends), curvature=True)
    return ends, view


def _spent(ends: list[Minimum]) -> int:
    return sum(end.evaluations for end in ends)


def _from_afar(
    problem: Problem, descend: Descent, ends: list[Minimum], at: int, most: int
) -> Minimum:
    """An end gone on with for as long as lower points are seen anywhere in the box."""
    end, others = ends[at], _spent(ends) - ends[at].evaluations
    for _ in range(ROUNDS):
        if not end.finished or not np.isfinite(end.value) or problem.constraints:
            break
        lower = lower_afar(problem, yardstick(problem, end.z), end.z)
        if lower is None or others + end.evaluations > most:
            break
        end = _followed(problem, descend, end, lower)
    return end


def _sharpened(problem: Problem, ends: list[Minimum], view: _View) -> tuple[list[Minimum], _View]:
    """The best end after a step of Newton's, which leaves what no difference of values shows."""
    best, hessian = best_of(ends), view.curved.hessian
    low, high = problem.space.box()
    inside = not (view.held.limits or view.held.weights.any())
    if hessian is None or not inside or view.near.rough or not view.curved.curvatures[0] > 0:
        return ends, view
    step = np.linalg.solve(hessian, view.held.gradient)
    z = best.z - step
    value, gradient = problem.value_and_gradient(z)
    lies_in = ((low < z) & (z < high)).all() and np.abs(step).max() < 1e-3
    still = np.abs(gradient).max() < view.yard.unit * np.abs(view.held.gradient).max()
    end = replace(best, evaluations=best.evaluations + 1)
    if lies_in and still and value - best.value <= 1e-12 * abs(best.value):
        end = replace(end, z=z, value=value)
        view = view._replace(held=view.held._replace(gradient=gradient / view.yard.unit))
    return [end if each is best else each for each in ends], view


def _simplex(problem: Problem, end: Minimum) -> Minimum:
    if not np.isfinite(end.value):
        return end
    limit = 200 * len(end.z)
    found = boxed(problem.value, end.z, problem.space.box(), step=0.5, tolerance=1e-5, limit=limit)
    total = end.evaluations + found.evaluations
    words = f"{end.message}, then a simplex search"
    if found.value < end.value:
        return replace(found, evaluations=total, message=words)
    return replace(end, evaluations=total)


def _followed(problem: Problem, descend: Descent, end: Minimum, lower: np.ndarray) -> Minimum:
    further = descend(problem, lower)
    total = end.evaluations + further.evaluations
    value = problem.value(lower)
    if further.allowed and further.value <= value:
        return replace(further, evaluations=total)
    return replace(end, z=lower, value=value, evaluations=total)


def _agrees(end: Minimum, best: Minimum, yard: Yardstick) -> bool:
    within = AGREE.get(yard.kind, yard.negligible)
    return end.allowed and yard.of(end.value - best.value) <= within


def _agreement(ends: list[Minimum], best: Minimum, yard: Yardstick) -> Starts:
    excess = [yard.of(end.value - best.value) if end.allowed else np.inf for end in ends]
    agreeing = sum(_agrees(end, best, yard) for end in ends)
    return Starts(len(ends), agreeing, max(excess))


def _status(problem: Problem, best: Minimum, view: _View, starts: Starts) -> Status:
    if not np.isfinite(best.value):
        return Status.FAILED
    if not best.allowed:
        return Status.INFEASIBLE
    alone = _status_of_point(problem, best, view)
    if alone.trusted and starts.count > 1 and not _most_agree(starts):
        return Status.STARTS_DIFFER
    return alone


def _most_agree(starts: Starts) -> bool:
    """Whether at least half of the starts, and two, came to the best value."""
    return starts.agreeing >= max(2, starts.count / 2)


def _status_of_point(problem: Problem, best: Minimum, view: _View) -> Status:
    """What a point is by itself."""
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
