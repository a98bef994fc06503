"""Whether an optimum exists at all: a search box that holds a solution is widened, again and again.

An objective may fall towards a limit that it reaches only at infinity: a solver would then return
whatever its box allows.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from tuner.certificate.solution import Solution, Status
from tuner.problem.problem import Problem

WIDENINGS = 4
FACTOR = 10.0
"""Positive parameters are let up and down by this factor, each time."""
ENOUGH = 0.9
"""Falls that shrink by at least this factor from box to box add up to a limit."""


def widen(problem: Problem, solve: Callable[[Problem], Solution]) -> Solution:
    """Solve a problem; where its box holds the solution, solve it in wider ones.

    Returns:
        A solution inside a wider box where there is one (the message says so); otherwise the first
        one, called unattained where the values fall towards a limit, unbounded where they do not.
    """
    first = solve(problem)
    if first.status is not Status.AT_BOUND:
        return first
    found = [first]
    while found[-1].certificate.active_bounds and len(found) <= WIDENINGS:
        wider = replace(problem, space=problem.space.widened(FACTOR ** len(found)))
        if wider.space == problem.space:
            return first
        found.append(solve(wider))
    last, total = found[-1], sum(solution.evaluations for solution in found)
    if last.status is Status.CONVERGED and not last.certificate.active_bounds:
        words = f"{last.message}; in a box {FACTOR ** (len(found) - 1):g} times as wide"
        return replace(last, message=words, evaluations=total)
    if last.status not in (Status.AT_BOUND, Status.CONVERGED):
        return replace(first, evaluations=total)
    status, words = _tendency([solution.value for solution in found])
    escaping = ", ".join(last.certificate.active_bounds)
    message = f"{status.sentence} ({words}; without end: {escaping})"
    return replace(first, status=status, message=message, evaluations=total)


def _tendency(values: list[float]) -> tuple[Status, str]:
    """Where the values in ever wider boxes go.

    >>> _tendency([0.5, 0.3, 0.26, 0.252, 0.2504])[1]
    'in ever wider boxes the value falls towards 0.25'
    >>> _tendency([1.0, 0.1, -5.0, -100.0])[0].value
    'unbounded'
    """
    falls = [a - b for a, b in pairwise(values)]
    ratio = falls[-1] / falls[-2] if falls[-2] > 0 else 0.0
    if falls[-1] > 0 and ratio > ENOUGH:
        return Status.UNBOUNDED, f"in ever wider boxes the value falls to {values[-1]:.3g} and on"
    limit = values[-1] - falls[-1] * ratio / (1 - ratio)  # Aitken: the falls shrink geometrically
    return Status.UNATTAINED, f"in ever wider boxes the value falls towards {limit:.6g}"
