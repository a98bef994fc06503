"""A search that goes on from what it ended at, for as long as lower points are seen."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tuner.certificate.kkt import Held, hold
from tuner.certificate.neighbours import Neighbours, lower_afar, neighbours
from tuner.certificate.spectrum import Spectrum, spectrum, unknown_spectrum
from tuner.certificate.yardstick import Yardstick, yardstick
from tuner.problem.problem import Problem
from tuner.solvers.agreement import agreement, agrees, most_agree
from tuner.solvers.minimum import Descent, Minimum, best_of
from tuner.solvers.simplex import boxed

ROUNDS = 4
"""How often a search goes on from a lower neighbour of its end."""


class View(NamedTuple):
    """A point looked at: how values are measured there, what holds it, curvature, neighbours."""

    yard: Yardstick
    held: Held
    curved: Spectrum
    near: Neighbours


def look(problem: Problem, end: Minimum, *, curvature: bool) -> View:
    """An end looked at; without curvature its gradient alone."""
    yard = yardstick(problem, end.z)
    held = hold(problem, end.z, yard.unit)
    if not curvature or not np.isfinite(end.value):
        return View(yard, held, unknown_spectrum(len(end.z)), Neighbours(None, False, False, 0))
    curved = spectrum(problem, yard, end.z, held)
    return View(yard, held, curved, neighbours(problem, yard, end.z, held, curved))


def gone_on(
    problem: Problem, descend: Descent, ends: list[Minimum], view: View
) -> tuple[list[Minimum], View]:
    """The ends, gone on with while lower points are seen; and the best one's view.

    It may cost as many evaluations as the search itself.
    """
    most = 2 * _spent(ends)
    for turn in range(ROUNDS):
        best = best_of(ends)
        if not (best.allowed and best.finished):
            break
        near = [_seen(problem, end, best, view) for end in ends]
        simplex = not problem.constraints and _misleading(view.near, turn)
        before = ends
        ends = [
            _stepped(problem, descend, end, its, turn, simplex=simplex)
            for end, its in zip(ends, near, strict=True)
        ]
        if all(after is end for after, end in zip(ends, before, strict=True)):
            break
        if simplex:
            ends = _repeated(problem, ends, view.yard)
        if best_of(ends) is not best:
            view = look(problem, best_of(ends), curvature=True)
        if _spent(ends) > most:
            return ends, view
    best = best_of(ends)
    for i in sorted(range(len(ends)), key=lambda i: ends[i].value):
        lowest = best_of(ends)
        alone = ends[i] is lowest and not most_agree(agreement(ends, lowest, view.yard))
        if alone or not agrees(ends[i], lowest, view.yard):
            ends = [*ends[:i], _from_afar(problem, descend, ends, i, most), *ends[i + 1 :]]
    if best_of(ends) is not best:
        view = look(problem, best_of(ends), curvature=True)
    return ends, view


def sharpened(problem: Problem, ends: list[Minimum], view: View) -> tuple[list[Minimum], View]:
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


_NOTHING = Neighbours(None, rough=False, steps=False, evaluations=0)


def _seen(problem: Problem, end: Minimum, best: Minimum, view: View) -> Neighbours:
    """What the neighbours of an end tell that is worth going on from.

    The best end, and each that was blocked before it came as low: at a jump of the objective,
    rounding decides on which side a descent comes to its end.
    """
    if end is best:
        return view.near
    if not end.blocked or agrees(end, best, view.yard):
        return _NOTHING
    return look(problem, end, curvature=True).near


def _misleading(near: Neighbours, turn: int) -> bool:
    """Whether the derivatives of a point do not show the way, or a descent did not find it."""
    return (near.rough and turn == 0) or (near.lower is not None and turn == 1)


def _stepped(
    problem: Problem,
    descend: Descent,
    end: Minimum,
    near: Neighbours,
    turn: int,
    *,
    simplex: bool,
) -> Minimum:
    """An end gone on with: from its lower neighbour, and by a simplex where slopes mislead.

    Args:
        near: what its own neighbours tell.
        turn: how often it has been gone on with.
        simplex: whether a simplex is wanted in any case.
    """
    further = end if near.lower is None else _followed(problem, descend, end, near.lower)
    simplex = simplex or (not problem.constraints and _misleading(near, turn))
    return _simplex(problem, further) if simplex else further


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


def _repeated(problem: Problem, ends: list[Minimum], yard: Yardstick) -> list[Minimum]:
    """The ends, the best one's simplex begun anew from it for as long as that leads lower.

    Across jumps a simplex shrinks before it has come to a minimum.
    """
    for _ in range(ROUNDS):
        best = best_of(ends)
        again = _simplex(problem, best)
        ends = [again if end is best else end for end in ends]
        if not yard.of(best.value - again.value) > yard.negligible:
            break
    return ends


def _simplex(problem: Problem, end: Minimum) -> Minimum:
    if not np.isfinite(end.value):
        return end
    limit = 200 * len(end.z)
    found = boxed(problem.value, end.z, problem.space.box(), step=0.5, tolerance=1e-5, limit=limit)
    total = end.evaluations + found.evaluations
    if found.value < end.value:
        return replace(found, evaluations=total, message="a simplex search from where slopes end")
    return replace(end, evaluations=total, blocked=False)


def _followed(problem: Problem, descend: Descent, end: Minimum, lower: np.ndarray) -> Minimum:
    further = descend(problem, lower)
    total = end.evaluations + further.evaluations
    value = problem.value(lower)
    if further.allowed and further.value <= value:
        return replace(further, evaluations=total)
    return replace(end, z=lower, value=value, evaluations=total)
