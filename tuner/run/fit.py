"""The main job: a recording and a filter go in, a tuned filter comes out."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from filters.declared import channel_facts
from tuner.catalogue import find
from tuner.certificate.solution import Solution
from tuner.data.merge import stacked, timeline
from tuner.data.plausible import implausible
from tuner.data.record import Record
from tuner.data.source import Source
from tuner.identifiability.determined import Determined, determined
from tuner.identifiability.noise import NoModelError
from tuner.problem.problem import Problem
from tuner.problem.surface import values
from tuner.run.fit_figures import figures
from tuner.run.judged import Judged, filter_name, first_part, judge
from tuner.run.posed import Posed, check_channels, pose
from tuner.run.result import FitRecord
from tuner.run.searched import Wishes
from tuner.run.study import Plan, Solutions, Task, best
from tuner.run.summary import five_lines
from tuner.solvers import Solver, make_solver

SCREENED = 64
"""Random points of the box that are tried before a search; it begins from the best of them."""


@dataclass(frozen=True)
class Request:
    """How a fit is solved.

    Attributes:
        solver: of ``tuner list solvers``.
        starts: of each search: the initial values first, then the best of random points.
        seed: where these come from.
        storage: database URL for samplers; "" for a temporary one.
        hold_out: whether a second fit on a part of the data is judged on the rest.
    """

    solver: str = "l-bfgs-b"
    starts: int = 4
    seed: int = 0
    storage: str = ""
    hold_out: bool = True


@dataclass(frozen=True, eq=False)
class Fit:
    """A filter tuned on a recording.

    Attributes:
        posed: the problem and its data.
        solution: the tuned values with their certificate.
        judged: what they are worth.
    """

    posed: Posed
    solution: Solution
    judged: Judged

    @property
    def params(self) -> Any:
        """The filter's parameters, as its ``init`` and ``step`` take them."""
        return self.posed.problem.params(self.solution)

    @cached_property
    def outputs(self) -> Any:
        """What the tuned filter returns over the recording, time first."""
        return self.posed.problem.outputs(self.solution)

    def summary(self) -> str:
        """Five lines: use these numbers, how good, why trust them, what is open, what next."""
        return "\n".join(five_lines(self.posed, self.solution, self.judged, folder=False))

    def __str__(self) -> str:
        return self.summary()


def fit(
    filter: str | type[Any],
    record: Record | Iterable[Record],
    *,
    start: Mapping[str, float] | None = None,
    fix: Mapping[str, float] | None = None,
    bound: Mapping[str, tuple[float, float]] | None = None,
    options: Mapping[str, Any] | None = None,
    objective: str | None = None,
    solver: str = "l-bfgs-b",
    starts: int = 4,
    seed: int = 0,
    hold_out: bool = True,
) -> Fit:
    """Tune a filter on a recording, or on several with one set of numbers for all.

    With a truth the filter's error is minimised, without one the likelihood of its innovations.

    Args:
        filter: a name of ``tuner list filters``, or a class that declares its facts.
        record: recordings in SI (:func:`tuner.read_record`, :meth:`tuner.Record.of`).
        start: where the search begins, by parameter.
        fix: parameters that are held, and at what.
        bound: the ends of the search, by parameter.
        options: fields of the filter's class.
        objective: of ``tuner list objectives``.
        solver: of ``tuner list solvers``.
        starts: of the search.
        seed: where the random ones come from.
        hold_out: whether a second fit on a part of the data is judged on the rest.

    Raises:
        ValueError: for what does not go together, in one sentence with the way out.

    >>> rng = np.random.default_rng(1)
    >>> level = np.cumsum(0.1 * rng.standard_normal(400))
    >>> record = Record.of({"z": level + rng.standard_normal(400)}, rate_hz=1.0)
    >>> found = fit("local-level", record, starts=1, hold_out=False)
    >>> 0.8 < float(found.solution.parameters["R"].value) < 1.2
    True
    """
    wishes = Wishes(start or {}, fix or {}, bound or {}, options or {}, objective)
    if not isinstance(filter, str | type):
        raise ValueError(f"{filter!r} is no filter's name or class; give {type(filter).__name__}")
    name = filter if isinstance(filter, str) else filter.__name__
    cls = find("tuner.filters", filter) if isinstance(filter, str) else filter
    records = (record,) if isinstance(record, Record) else tuple(record)
    posed = pose_on(name, cls, records, wishes)
    plan = plan_fit(posed, Request(solver, starts, seed, "", hold_out))
    solved = {(t.problem.name, t.solver.name): t.solver(t.problem) for t in plan.tasks}
    return concluded(posed, solved)


def pose_on(name: str, cls: type[Any], records: tuple[Record, ...], wishes: Wishes) -> Posed:
    """The problem of tuning a filter on recordings, merged each and side by side.

    Raises:
        ValueError: as :func:`tuner.run.posed.pose`, and for recordings that do not go together.
    """
    lines = [timeline(record) for record in records]
    if not lines:
        raise ValueError(f"{name} needs a recording to be tuned on; give one at least")
    for line in lines:
        check_channels(name, cls, line)
    facts = channel_facts(cls, "inputs"), channel_facts(cls, "outputs")
    strange = [words for line in lines for words in implausible(line, *facts)]
    source = _source([part for record in records for part in record.sources])
    line = lines[0] if len(lines) == 1 else stacked(lines)
    posed = pose(name, cls, line, wishes, source)
    known = known_of(posed.problem)
    open_ = () if known is None else known.sentences
    return replace(posed, notes=(*strange, *line.notes, *open_))


def _source(parts: list[Source]) -> Source:
    """Where recordings come from: their files, of which one may hold many recordings."""
    files = {(part.name, part.sha256) for part in parts}
    if len(files) == 1:
        return replace(parts[0], samples=sum(part.samples for part in parts))
    return Source.joined(" + ".join(dict.fromkeys(part.name for part in parts)), parts)


def plan_fit(posed: Posed, request: Request) -> Plan:
    """What is solved, exported and drawn."""
    solver = make_solver(
        request.solver, seed=request.seed, starts=request.starts, storage=request.storage
    )
    part = first_part(posed) if request.hold_out else None
    if part is not None:  # by itself: its starts know nothing of what is held out
        part = screened(part, request)
    posed = replace(posed, problem=screened(posed.problem, request))
    tasks = [Task(posed.problem, solver)]
    tasks += [] if part is None else [Task(part, _quick(solver))]
    return Plan(
        source=posed.source,
        tasks=tuple(tasks),
        exports=(posed.problem.name,),
        case=posed,
        claims=(),
        figures=figures,
        report=report,
        notes=posed.notes,
    )


def report(posed: Posed, solutions: Solutions) -> FitRecord:
    """What a fit is worth, for its result."""
    found = concluded(posed, solutions)
    lines = five_lines(posed, found.solution, found.judged)
    return FitRecord.of(found.judged, filter_name(posed), lines)


def concluded(posed: Posed, solutions: Solutions) -> Fit:
    """The fit that solutions of its plan amount to."""
    name = posed.problem.name
    solution = best(name, solutions)
    parts = [problem for problem, _ in solutions if problem == f"{name}_part"]
    part = best(parts[0], solutions) if parts else None
    return Fit(posed, solution, judge(posed, solution, part))


def screened(problem: Problem, request: Request) -> Problem:
    """The problem with known starts: what its differences suggest, then the best of random points."""
    if request.starts < 2 or not problem.space.size:
        return problem
    points = problem.space.starts(1 + SCREENED, request.seed)[1:]
    found = values(problem, points)
    order = np.argsort(found)[: request.starts - 1]
    screened = tuple(points[i] for i in order if found[i] < np.inf)
    known = known_of(problem)
    first = () if known is None else (known.start,)
    return replace(problem, known_starts=(*first, *screened)[: request.starts - 1])


def known_of(problem: Problem) -> Determined | None:
    """What differences of measurements say of the noise; None where they say nothing."""
    try:
        return determined(problem)
    except NoModelError:
        return None


def _quick(solver: Solver) -> Solver:
    """The solver without a look at second derivatives, which nobody reads of the second fit."""
    known: Any = solver
    return replace(known, curvature=False) if hasattr(solver, "curvature") else solver
