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
        best, lower = best_of(ends), view.near.lower
        # What a second descent did not find either, the derivatives do not show.
        rough = (view.near.rough and turn == 0) or (lower is not None and turn == 1)
        if not (best.allowed and best.finished) or not (rough or lower is not None):
            break
        if lower is not None:
            ends = [_followed(problem, descend, e, lower) if e is best else e for e in ends]
        if rough and not problem.constraints:
            ends = [_simplex(problem, end) for end in ends]
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
