"""How the objective rises around a solution: what the data determine, as a picture."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from objectives.in_numpy import Method, in_numpy
from tuner.certificate.solution import Solution
from tuner.certificate.yardstick import NATS_95, SHARE, yardstick
from tuner.problem.parameters import Fixed, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.surface import values
from tuner.run.figure import Chart, Line, Map
from tuner.run.report_figure import ReportFigure

STEPS = 2e7
"""Filter steps times squared states that a picture may cost."""
MOST, FEWEST, ALONG = 25, 11, 41
"""Points of a map along a side; of a curve."""
WIDE, UNKNOWN = 2.2, 3.0
"""Half a side in half intervals; and where there is no interval, in coordinates."""
NATS_95_OF_TWO = 2.996
"""Half the 95 % quantile of chi-square with two degrees of freedom."""
NATS = (0.0, 0.5, NATS_95_OF_TWO, 6.0, 12.0, 25.0, 50.0, 100.0, 300.0, 1e3, 1e4, 1e5)
PERCENT = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4, 1e5)


class Side(NamedTuple):
    """A free parameter that a picture goes along.

    Attributes:
        name, unit: of it.
        at: its place in z.
        z: points along it.
        values: the parameter there.
        log: whether they are even in its logarithm.
        best: and at the solution.
        interval: its interval, where there is one.
    """

    name: str
    unit: str
    at: int
    z: np.ndarray
    values: np.ndarray
    log: bool
    best: float
    interval: tuple[float, float] | None

    @property
    def label(self) -> str:
        """Of an axis."""
        return f"{self.name}, {self.unit}" if self.unit else self.name


def surface(problem: Problem, solution: Solution) -> Iterator[ReportFigure]:
    """A curve over one free parameter, a map over two; nothing where that would take long."""
    free = [*_free(problem, solution)]
    if not free or not np.isfinite(solution.value) or problem.filter is None:
        return
    count = _points(problem, len(free))
    if count == 0:
        return
    yard = yardstick(problem, solution.z)
    unit, kind = yard.unit, yard.kind
    sides = [_side(problem, solution, name, at, count) for name, at in _widest(free, solution)]
    Z = _grid(solution.z, sides)
    found = values(problem, Z)
    rise = np.where(np.isfinite(found), (found - solution.value) / unit, np.nan)
    rise = rise if kind == "likelihood" else 100 * rise
    if len(sides) == 1:
        yield _curve(sides[0], rise, likelihood=kind == "likelihood")
    else:
        shaped = rise.reshape(len(sides[0].z), len(sides[1].z))
        held = [name for name, _ in free if name not in (sides[0].name, sides[1].name)]
        yield _map(sides, shaped, held, likelihood=kind == "likelihood")


def _free(problem: Problem, solution: Solution) -> Iterator[tuple[str, int]]:
    """Free parameters of one number, each with its place in z."""
    at = 0
    for name, kind in problem.space.parameters:
        if kind.size == 1 and not isinstance(kind, Fixed):
            yield name, at
        at += kind.size


def _points(problem: Problem, free: int) -> int:
    """Along a side; 0 where even few would take too long."""
    samples = int(np.prod(np.shape(problem.data.truth)[:2])) if np.ndim(problem.data.truth) else 1
    states = max(len(problem.what_is_exported().states), 1)
    affordable = STEPS / (max(samples, 1) * states**2)
    if free == 1:
        return ALONG if affordable >= ALONG else 0
    side = int(np.sqrt(affordable))
    return 0 if side < FEWEST else min(side, MOST)


def _widest(free: list[tuple[str, int]], solution: Solution) -> list[tuple[str, int]]:
    """The two that the data determine least, in their own order."""

    def width(item: tuple[str, int]) -> float:
        interval = solution.parameters[item[0]].interval
        if interval is None or not interval[0] > 0 or not np.isfinite(interval[1]):
            return np.inf
        return float(np.log(interval[1] / interval[0]))

    chosen = sorted(free, key=width, reverse=True)[:2]
    return [each for each in free if each in chosen]


def _side(problem: Problem, solution: Solution, name: str, at: int, count: int) -> Side:
    kind: Parameter = dict(problem.space.parameters)[name]
    tuned = solution.parameters[name]
    low, high = (float(end[at]) for end in problem.space.box())
    center, reach = float(solution.z[at]), UNKNOWN
    if tuned.interval is not None:
        ends = [_z_of(kind, end) for end in tuned.interval]
        known = [abs(end - center) for end in ends if np.isfinite(end)]
        reach = WIDE * max(known, default=UNKNOWN / WIDE) or UNKNOWN
    z = np.linspace(max(center - reach, low), min(center + reach, high), count)
    along = np.array([float(in_numpy(Method(kind, "constrain"), each[None])) for each in z])
    log = isinstance(kind, Positive)
    return Side(name, tuned.unit, at, z, along, log, float(tuned.value), tuned.interval)


def _z_of(kind: Parameter, value: float) -> float:
    try:
        return float(kind.unconstrain(np.asarray(value))[0])
    except ValueError:
        return float("nan")


def _grid(z: np.ndarray, sides: list[Side]) -> np.ndarray:
    mesh = np.meshgrid(*(side.z for side in sides), indexing="ij")
    Z = np.repeat(z[None, :], mesh[0].size, axis=0)
    for side, along in zip(sides, mesh, strict=True):
        Z[:, side.at] = along.ravel()
    return Z


def _curve(side: Side, rise: np.ndarray, *, likelihood: bool) -> ReportFigure:
    limit = NATS_95 if likelihood else 100 * SHARE
    ends = side.values[[0, -1]]
    words = "95 % limit" if likelihood else "1 % above the best"
    lines = (
        Line(words, ends, np.full(2, limit), drawn="limit"),
        Line("objective", side.values, np.maximum(rise, 0.0)),
        Line("tuned", np.array([side.best]), np.zeros(1)),
    )
    determined = side.interval is not None
    chart = Chart(
        name="objective",
        title=f"{side.name} is {'' if determined else 'not '}determined: the objective "
        f"{'rises to both sides' if determined else 'hardly rises'}",
        x_label=side.label,
        y_label="nats above the best" if likelihood else "per cent above the best",
        lines=lines,
        log="x" if side.log else "",
    )
    return ReportFigure(
        "certificate", chart, "The objective of the whole recording over this parameter."
    )


def _map(sides: list[Side], rise: np.ndarray, held: list[str], *, likelihood: bool) -> ReportFigure:
    one, other = sides
    spot = Line("tuned", np.array([one.best]), np.array([other.best]))
    open_ = [side.name for side in sides if side.interval is None]
    title = f"The objective has one minimum in {one.name} and {other.name}"
    if open_:
        title = f"The objective hardly changes along {' and '.join(open_)}"
    note = "Increase of the objective of the whole recording above its value at the tuned values."
    if held:
        note += f" A section at the tuned {' and '.join(held)}."
    figure = Map(
        name="objective",
        title=title,
        x_label=one.label,
        y_label=other.label,
        z_label="nats above the best" if likelihood else "per cent above the best",
        x=one.values,
        y=other.values,
        z=np.maximum(rise, 0.0),
        marks=(spot,),
        log="x" * one.log + "y" * other.log,
    )
    if likelihood:
        return ReportFigure(
            "certificate", figure, note, NATS, (NATS_95_OF_TWO, "95 % region of both")
        )
    return ReportFigure("certificate", figure, note, PERCENT, (100 * SHARE, "1 % above the best"))
