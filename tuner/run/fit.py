"""The plan of a fit: what is posed, solved, drawn and judged."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from filters.declared import bare, channel_facts
from tuner.certificate.solution import Solution, Status
from tuner.data.merge import stacked, timeline
from tuner.data.plausibility import check_plausibility
from tuner.data.record import Record
from tuner.data.source import Source
from tuner.identifiability.determined import Determined, determined
from tuner.identifiability.noise import NoModelError
from tuner.problem.facts import check_facts
from tuner.problem.problem import Problem
from tuner.problem.surface import values
from tuner.processors import side_by_side
from tuner.run.background_work import compiled_ahead
from tuner.run.figure import Figure
from tuner.run.finding import Finding
from tuner.run.fit_figures import figures
from tuner.run.fit_problem import Posed, check_channels, pose
from tuner.run.fit_record import FitRecord
from tuner.run.fit_report_figures import report_figures
from tuner.run.front import Against, picture_of, trade
from tuner.run.held_out import judge_held_out
from tuner.run.judgement import Judged, filter_name, judge
from tuner.run.noise_table import gain_findings, noise_findings
from tuner.run.report_figure import ReportFigure
from tuner.run.search_space import Wishes
from tuner.run.sharing import OneForAll, shared
from tuner.run.split import HeldOutBy, Parting, parting
from tuner.run.study import Plan, Solutions, Task, best
from tuner.run.summary import five_lines, in_doubt
from tuner.run.variance_scaling import WithScaledVariances, can_scale_variances, scaling_of
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
        held_out: what a second fit does not see and is judged on; None decides by what there is.
    """

    solver: str = "l-bfgs-b"
    starts: int = 4
    seed: int = 0
    storage: str = ""
    held_out: HeldOutBy | None = None


@dataclass(frozen=True, eq=False)
class Fitting:
    """The subject of a fit's plan.

    Attributes:
        posed: the problem and its data.
        parted: what is held out of them; None where nothing is.
        against: a second objective; None without one.
    """

    posed: Posed
    parted: Parting | None
    against: Against | None = None


class Found(NamedTuple):
    """The outcome of a fit's plan: the solution on all data, and its worth."""

    solution: Solution
    judged: Judged


def asked_for(hold_out: bool, held_out: HeldOutBy | None) -> HeldOutBy | None:
    """The held-out data, from whether there are any and which they are to be.

    Raises:
        ValueError: for a part that is to be held out where nothing is.
    """
    if hold_out:
        return held_out
    if held_out not in (None, "none"):
        raise ValueError(
            f"held_out={held_out} and no hold-out exclude each other; give one of them"
        )
    return "none"


def pose_on(name: str, cls: type[Any], records: tuple[Record, ...], wishes: Wishes) -> Posed:
    """The problem of tuning a filter on recordings, merged each and side by side.

    Raises:
        ValueError: as :func:`tuner.run.fit_problem.pose`, and for recordings that do not match.
    """
    check_facts(cls)
    lines = [timeline(record) for record in records]
    if not lines:
        raise ValueError(f"{name} needs a recording; give at least one")
    for line in lines:
        check_channels(name, cls, line)
    facts = channel_facts(cls, "inputs"), channel_facts(cls, "outputs")
    strange = [words for line in lines for words in check_plausibility(line, *facts)]
    source = _source([part for record in records for part in record.sources])
    line = lines[0] if len(lines) == 1 else stacked(lines)
    posed = pose(name, cls, line, wishes, source)
    known = None if wishes.held else known_of(posed.problem)
    open_ = () if known is None else known.sentences
    left = () if posed.left_out is None else (posed.left_out.words,)
    notes = (*strange, *line.notes, *left, *open_)
    return replace(posed, notes=notes, undetermined=open_, known=known)


def _source(parts: list[Source]) -> Source:
    """Where recordings come from: their files, of which one may hold many recordings."""
    files = {(part.name, part.sha256) for part in parts}
    if len(files) == 1:
        return replace(parts[0], samples=sum(part.samples for part in parts))
    return Source.joined(" + ".join(dict.fromkeys(part.name for part in parts)), parts)


def plan_fit(posed: Posed, request: Request, other: Posed | None = None) -> Plan:
    """The tasks, exports and figures; against another objective the front of both."""
    solver = _solver(request)
    with compiled_ahead(posed.problem):
        parted = parting(posed.problem, request.held_out)
        main, second = _screened(posed, parted, request)
        posed = replace(posed, problem=main)
    own = WithScaledVariances(solver) if can_scale_variances(posed) else solver
    tasks = [Task(posed.problem, own), *second]
    against = None if other is None else Against.by(other, solver, posed.problem)
    case = Fitting(posed, parted, against)
    return Plan(
        source=posed.source,
        tasks=tuple(tasks),
        exports=(posed.problem.name,),
        case=case,
        claims=(),
        figures=_figures,
        report=report,
        notes=posed.notes,
        findings=findings,
        report_figures=_report_figures,
        share=_share,
        last=_last,
    )


def _share(case: Fitting, url: str) -> Fitting:
    """With a front whose points are found together with other processes."""
    if case.against is None:
        return case
    solver = OneForAll(shared(case.against.solver, url), url)
    return replace(case, against=replace(case.against, solver=solver))


def _last(case: Fitting) -> None:
    """The front, which :attr:`Against.front` keeps."""
    if case.against is not None:
        _ = case.against.front


def _screened(posed: Posed, parted: Parting | None, request: Request) -> tuple[Problem, list[Task]]:
    """The problem with known starts, and second fits: they know nothing of what they do not see."""
    tuned, alone = ((), ()) if parted is None else (parted.tuned, parted.alone)
    # What could be had there is beside the point, and needs less certainty.
    few = replace(request, starts=min(request.starts, 2))
    asked = [
        (posed.problem, request, posed.known),
        *((part, request, None) for part in tuned),
        *((part, few, None) for part in alone),
    ]
    main, *others = side_by_side(lambda each: screened(*each), asked)
    solvers = [_quick(_solver(how)) for _, how, _ in asked[1:]]
    return main, [Task(*each) for each in zip(others, solvers, strict=True)]


def _figures(case: Fitting, solutions: Solutions) -> Iterator[Figure]:
    yield from figures(case.posed, solutions)
    if case.against is not None:
        yield from picture_of(case.posed, trade(case.against))


def _report_figures(case: Fitting, solutions: Solutions) -> Iterator[ReportFigure]:
    yield from report_figures(case.posed, solutions, case.against)


def findings(case: Fitting, solutions: Solutions) -> Iterator[Finding]:
    """The noise a sample and as densities, and the gains, in the units that people take them in."""
    problem = case.posed.problem
    solution = best(problem.name, solutions)
    filter = bare(problem.filter)
    if solution.status is Status.FAILED or not getattr(filter, "dt", None):
        return
    values = {name: p.value for name, p in solution.parameters.items()}
    units = {name: p.unit for name, p in solution.parameters.items()}
    yield from noise_findings(filter, values, units)
    yield from gain_findings(problem.what_is_exported().derived(problem.params(solution)))


def report(case: Fitting, solutions: Solutions) -> FitRecord:
    """The worth of a fit, for its result."""
    found = concluded(case, solutions)
    lines = five_lines(case.posed, found.solution, found.judged)
    doubt = in_doubt(case.posed, found.solution, found.judged)
    return FitRecord.of(found.judged, filter_name(case.posed), lines, doubt)


def concluded(case: Fitting, solutions: Solutions) -> Found:
    """The outcome of its plan's solutions."""
    posed, parted = case.posed, case.parted
    solved = {name: best(name, solutions) for name, _ in solutions}
    held_out = None if parted is None else judge_held_out(posed, parted, solved)
    solution = solved[posed.problem.name]
    judged = judge(posed, solution, held_out)
    if can_scale_variances(posed):
        judged = replace(judged, rescaled=scaling_of(posed.problem, solution))
    if case.against is not None:
        judged = replace(judged, trade=trade(case.against))
    return Found(solution, judged)


def screened(problem: Problem, request: Request, known: Determined | None = None) -> Problem:
    """The problem with known starts: what its differences suggest, and the best random points.

    Args:
        problem: the problem.
        request: how many starts, and where the random points come from.
        known: what :func:`known_of` finds of this problem, where that has been done.
    """
    if request.starts < 2 or not problem.space.size:
        return problem
    points = problem.space.starts(1 + SCREENED, request.seed)[1:]
    found = values(problem, points)
    order = np.argsort(found)[: request.starts - 1]
    screened = tuple(points[i] for i in order if found[i] < np.inf)
    known = known or known_of(problem)
    first = () if known is None else (known.start,)
    return replace(problem, known_starts=(*first, *screened)[: request.starts - 1])


def known_of(problem: Problem) -> Determined | None:
    """The noise estimated from differences of measurements; None where there is no estimate."""
    try:
        return determined(problem)
    except NoModelError:
        return None


def _solver(request: Request) -> Solver:
    return make_solver(
        request.solver, seed=request.seed, starts=request.starts, storage=request.storage
    )


def _quick(solver: Solver) -> Solver:
    """The solver without a look at second derivatives, which nobody reads of the second fit."""
    known: Any = solver
    return replace(known, curvature=False) if hasattr(solver, "curvature") else solver
