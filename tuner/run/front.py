"""The front of a fit's objective and another one: what a user asks for, a picture, and words."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from objectives import Objective
from objectives.in_numpy import Method, in_numpy
from tuner.problem.parameters import Fixed
from tuner.problem.problem import Problem
from tuner.run.figure import Chart, Line
from tuner.run.fit_problem import NO_TRUTH, Posed, pose
from tuner.run.search_space import Wishes
from tuner.solvers.pareto import Front, pareto
from tuner.solvers.solver import Solver

POINTS = 12
"""Of a front at most."""


@dataclass(frozen=True, eq=False)
class Against:
    """A second objective of a fit.

    Attributes:
        posed: the same filter and data, judged by it.
        solver: of every point of the front.
        first: the fit's problem.
    """

    posed: Posed
    solver: Solver
    first: Problem

    @cached_property
    def front(self) -> Front:
        """The front, searched once."""
        other, truth = self.posed.problem.objective, self.posed.problem.data.truth
        return pareto(self.first, other, truth, solver=self.solver, points=POINTS)

    @classmethod
    def by(cls, posed: Posed, solver: Any, first: Problem) -> "Against":
        """The front by the solver of a fit, from the initial values and from both neighbours."""
        few = replace(solver, starts=3) if hasattr(solver, "starts") else solver
        return cls(posed, few, first)


@dataclass(frozen=True)
class Traded:
    """One point of a front, as people read it.

    Attributes:
        first, second: the values of both objectives; of a likelihood the equivalent deviation.
        weight: of the second.
        knee: whether it is the knee.
        status: of its solution.
        parameters: those that were tuned, by name.
    """

    first: float
    second: float
    weight: float
    knee: bool
    status: str
    parameters: dict[str, Any]


@dataclass(frozen=True)
class Trade:
    """The trade-off between a fit's objective and another one.

    Attributes:
        objective: the second one's name.
        unit: of its values.
        depth: of the knee; 0 without one.
        points: from the best in the first to the best in the second.
    """

    objective: str
    unit: str
    depth: float
    points: tuple[Traded, ...]


def in_order(objective: str | None, against: str | None) -> tuple[str | None, str | None]:
    """The one that needs a truth first: the other one needs none.

    Raises:
        ValueError: for the same objective twice.
    """
    if against is not None and objective == against:
        raise ValueError(f"a front is of two objectives, and both are {against}; give another one")
    if objective in NO_TRUTH and against not in (None, *NO_TRUTH):
        return against, objective
    return objective, against


def posed_against(name: str, cls: type[Any], posed: Posed, wishes: Wishes, objective: str) -> Posed:
    """The same fit by another objective.

    Raises:
        ValueError: as :func:`tuner.run.fit_problem.pose`, and for the fit's own objective.
    """
    if objective == posed.objective:
        raise ValueError(
            f"a front is of two objectives, and both are {objective}; give another one"
        )
    truth: Mapping[str, Any] = {} if objective in NO_TRUTH else posed.timeline.truth
    timeline = replace(posed.timeline, truth=truth)
    return pose(name, cls, timeline, replace(wishes, objective=objective), posed.source)


def trade(against: Against) -> Trade:
    """The front as people read it."""
    front, first, second = against.front, against.first, against.posed
    free = [name for name, kind in first.space.parameters if not isinstance(kind, Fixed)]
    points = [
        Traded(
            first=_shown(first.objective, point.first),
            second=_shown(second.problem.objective, point.second),
            weight=point.weight,
            knee=i == front.knee,
            status=point.solution.status.value,
            parameters={n: point.solution.parameters[n].value.tolist() for n in free},
        )
        for i, point in enumerate(front.points)
    ]
    return Trade(second.objective, second.unit, front.depth, tuple(points))


def _shown(objective: Objective, value: float) -> float:
    known: Any = objective
    if not hasattr(known, "deviation"):
        return value
    return float(in_numpy(Method(known, "deviation"), value))


def picture_of(posed: Posed, found: Trade) -> Iterator[Chart]:
    """Both objectives, each point the best in one for the other; with the knee.

    Between points that are far apart nothing need be: what joins them is not drawn as a curve.
    """
    front, between = (_line(label, found.points) for label in ("front", "between its points"))
    lines = [replace(front, drawn="points")]
    if len(found.points) > 1:
        lines.append(replace(between, drawn="limit"))
    lines += [_line("knee", [each]) for each in found.points if each.knee]
    labels = [
        f"{name}, {unit}" if unit else name
        for name, unit in ((posed.objective, posed.unit), (found.objective, found.unit))
    ]
    yield Chart(
        name=f"{posed.problem.name}_front",
        title=f"Trade-off between {posed.objective} and {found.objective}",
        x_label=labels[0],
        y_label=labels[1],
        lines=tuple(lines),
    )


def _line(label: str, points: Any) -> Line:
    return Line(
        label, np.array([each.first for each in points]), np.array([each.second for each in points])
    )


def words(posed: Posed, found: Trade) -> str:
    """The front in a sentence: what is given up at the knee, and what for."""
    first, last = found.points[0], found.points[-1]
    if len(found.points) == 1:
        return f"{posed.objective} and {found.objective} have the same minimum"
    ends = (
        f"against {found.objective}: {_more(last.first, first.first)} more {posed.objective} gives "
        f"{100 * (1 - last.second / first.second):.2g} % less {found.objective}"
    )
    knee = next((each for each in found.points if each.knee), None)
    if knee is None:
        return f"{ends}, and there is no knee"
    numbers = ", ".join(f"{n} = {np.asarray(v):.4g}" for n, v in knee.parameters.items())
    return (
        f"{ends}; at the knee {numbers}: {_more(knee.first, first.first)} and "
        f"{_more(knee.second, last.second)} above the minimum of each"
    )


def _more(value: float, least: float) -> str:
    return f"{100 * (value / least - 1):.2g} %"
