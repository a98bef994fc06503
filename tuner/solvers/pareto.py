"""Two objectives at once: the front of what is best in either for the other, and its knee."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from objectives import Objective, is_fold
from objectives.pair import Both, WeighedPair, logarithm
from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.solvers.solver import Solver

END = 1e-3
"""Weight of the other objective at either end: what the one leaves open the other decides."""
BELOW = 1e-3
"""Points that lie less than this below the chord of their neighbours, in logarithms, are on it."""
ONE = 1e-4
"""Ends that differ by less in either logarithm are one."""


@dataclass(frozen=True, eq=False)
class FrontPoint:
    """One point of a front: nothing is better in both objectives.

    Attributes:
        first, second: the values of both.
        weight: of the second objective.
        logs: the logarithms of both values; of a likelihood its nats.
        solution: of the weighed problem, with its certificate.
    """

    first: float
    second: float
    weight: float
    logs: tuple[float, float]
    solution: Solution


@dataclass(frozen=True, eq=False)
class Front:
    """The points of a front, from the best in the first objective to the best in the second.

    Attributes:
        points: in order; one alone where one point is the best in both.
        knee: which of them lies furthest below the chord between the ends, both logarithms scaled
            to the range of the front; None where none lies below it.
        depth: how far the knee lies below, as a share of that range; at most 1.
    """

    points: tuple[FrontPoint, ...]
    knee: int | None
    depth: float


def pareto(
    problem: Problem,
    against: Objective,
    truth: Any = None,
    *,
    solver: Solver,
    points: int = 12,
) -> Front:
    """The Pareto front of a problem's objective and another one.

    Each point minimises a weighed sum of both logarithms. The weights are those of the chords
    between points found before (noninferior set estimation, Cohon, Multiobjective Programming and
    Planning, 1978, ch. 6), the deepest first. So the first point between the ends is the knee:
    what is least in the direction square to the chord between the ends is furthest from it (Das,
    Structural Optimization 18, 1999). What bends inwards, away from every chord, is not found.

    Args:
        problem: with the first objective.
        against: the second.
        truth: what the second holds the outputs against, time first; None: as the first.
        solver: of every point; it begins anew and at both neighbours.
        points: how many there are at most.

    Raises:
        ValueError: for fewer than three points, an objective that takes no part in the time loop,
            a problem without a filter, and objectives that reach 0 or are no number.
    """
    if points < 3:
        raise ValueError(f"a front needs three points at least, got {points}; give more")
    for objective in (problem.objective, against):
        if problem.filter is None or not is_fold(objective):
            raise ValueError(
                f"{type(objective).__name__} cannot be weighed against another objective: a front "
                "needs a filter that is run and objectives that sum up as it runs"
            )
    search = _Search(problem, against, problem.data.truth if truth is None else truth, solver)
    found = [search.point(END, ()), search.point(1 - END, ())]
    found[1] = search.point(1 - END, (found[0].solution.z,))
    if _one(*found):
        return Front((found[0],), None, 0.0)
    closed: set[tuple[float, float]] = set()
    while len(found) < points and (gap := _widest(found, closed)) is not None:
        left, right = found[gap], found[gap + 1]
        middle = search.between(left, right)
        if _below(middle, left, right) < BELOW:
            closed.add((left.weight, right.weight))
        else:
            found.insert(gap + 1, middle)
    return _front(_undominated(found))


@dataclass(frozen=True, eq=False)
class _Search:
    problem: Problem
    against: Objective
    truth: Any
    solver: Solver

    def between(self, left: FrontPoint, right: FrontPoint) -> FrontPoint:
        """The point furthest below the chord of two others."""
        fall = left.logs[1] - right.logs[1]
        rise = right.logs[0] - left.logs[0]
        return self.point(rise / (rise + fall), (left.solution.z, right.solution.z))

    def point(self, weight: float, known: tuple[np.ndarray, ...]) -> FrontPoint:
        """The best point for a weight."""
        problem = self.problem
        rows = len(np.asarray(problem.data.truth))
        both = Both(problem.data.truth, self.truth, np.full(rows, weight))
        first: Any = problem.objective
        second: Any = self.against
        weighed = replace(
            problem,
            name=f"{problem.name}_front",
            objective=WeighedPair(first, second),
            data=problem.data._replace(truth=both),
            known_starts=(*known, *problem.known_starts),
        )
        solution = self.solver(weighed)
        values = self._values(solution.z)
        pairs = zip((first, second), values, strict=True)
        logs = [float(logarithm(objective, value)) for objective, value in pairs]
        if not np.isfinite(logs).all():
            raise ValueError(
                f"a front needs objectives above 0, and with a weight of {weight:.3g} they are "
                f"{values[0]:.3g} and {values[1]:.3g}; give others"
            )
        return FrontPoint(*values, weight, (logs[0], logs[1]), solution)

    def _values(self, z: np.ndarray) -> tuple[float, float]:
        data = self.problem.data._replace(truth=self.truth)
        other = replace(self.problem, objective=self.against, data=data)
        return self.problem.value(z), other.value(z)


def _one(left: FrontPoint, right: FrontPoint) -> bool:
    """Whether both ends are the same in one objective at least: nothing is traded."""
    return right.logs[0] - left.logs[0] < ONE or left.logs[1] - right.logs[1] < ONE


def _below(point: FrontPoint, left: FrontPoint, right: FrontPoint) -> float:
    """How far a point lies below a chord, as a share of the chord's own range."""
    shares = [
        (point.logs[i] - least.logs[i]) / (most.logs[i] - least.logs[i])
        for i, least, most in ((0, left, right), (1, right, left))
    ]
    return 1 - sum(shares)


def _widest(found: list[FrontPoint], closed: set[tuple[float, float]]) -> int | None:
    """The longest chord that may have something below it, in the range of the whole front."""
    spans = np.ptp([point.logs for point in found], axis=0)
    lengths = {
        i: float(np.hypot(*((np.array(right.logs) - left.logs) / spans)))
        for i, (left, right) in enumerate(_chords(found))
        if (left.weight, right.weight) not in closed and not _one(left, right)
    }
    return max(lengths, key=lambda i: lengths[i]) if lengths else None


def _chords(found: list[FrontPoint]) -> Iterator[tuple[FrontPoint, FrontPoint]]:
    yield from pairwise(found)


def _undominated(found: list[FrontPoint]) -> list[FrontPoint]:
    """Without what another point is better than in both: a search may end in a worse minimum."""
    return [
        point
        for point in found
        if not any(other.first < point.first and other.second < point.second for other in found)
    ]


def _front(found: list[FrontPoint]) -> Front:
    depths = [_below(point, found[0], found[-1]) for point in found]
    knee = int(np.argmax(depths))
    if depths[knee] < BELOW:
        return Front(tuple(found), None, 0.0)
    return Front(tuple(found), knee, depths[knee])
