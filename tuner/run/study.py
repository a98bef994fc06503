"""The protocol of a study, and how studies are found."""

from collections.abc import Callable, Collection, Iterable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from tuner.catalogue import find, names
from tuner.data.source import Source
from tuner.names import unknown
from tuner.run.comparison import Comparison
from tuner.run.figure import Figure
from tuner.run.finding import Finding
from tuner.run.report_figure import ReportFigure

if TYPE_CHECKING:
    from jax import Array
    from pydantic import BaseModel

    from filters.declared import Channel
    from tuner.certificate.solution import Solution
    from tuner.data.record import Record
    from tuner.export.tuned import Tuned
    from tuner.problem.problem import Problem
    from tuner.run.at_rate import AtRate
    from tuner.run.fit_record import FitRecord
    from tuner.solvers.convex import ConvexTask
    from tuner.solvers.solver import Solver


@dataclass(frozen=True)
class Task:
    """One problem, or convex program, for one solver."""

    problem: "Problem | ConvexTask"
    solver: "Solver"


Solutions: TypeAlias = "Mapping[tuple[str, str], Solution]"
"""Solutions by the names of problem and solver."""


def no_findings(case: Any, solutions: Solutions) -> "tuple[Finding, ...]":
    """Nothing but solutions was found."""
    return ()


def as_it_is(case: Any, url: str) -> Any:
    """Nothing of a case is shared."""
    return case


def nothing_more(case: Any) -> None:
    """Nothing is searched once the tasks are solved."""


def best(problem: str, solutions: Solutions) -> "Solution":
    """The solution of a problem with the lowest value; among equals (to 1e-6) a converged one."""
    candidates = [s for (name, _), s in solutions.items() if name == problem]
    if not candidates:
        raise ValueError(f"there is no solution of {problem}; run it again")
    lowest = min(s.value for s in candidates)
    equals = [s for s in candidates if s.value <= lowest + 1e-6 * abs(lowest)]
    return min(equals, key=lambda s: (not s.status.trusted, s.value))


def tuned_values(solution: "Solution") -> "dict[str, Array]":
    """The parameters that a solution found, by name, as filters take them."""
    import jax.numpy as jnp

    return {name: jnp.asarray(p.value) for name, p in solution.parameters.items()}


@dataclass(frozen=True)
class Claim:
    """One claim or number of a paper, and the function that tries it.

    Attributes:
        name: the row's name, "exp2.order_S_phi"; with * or ? where the function returns a row for
            each of several things: "*.q_over_r".
        rows: from the study's case and the solutions to its row or rows.
        needs: names of the problems, with * and ?, whose solutions it asks for. Without any it is
            tried while the searches run, and is given no solution.
    """

    name: str
    rows: "Callable[[Any, Solutions], Comparison | Iterable[Comparison]]"
    needs: tuple[str, ...] = ()

    def compare(self, case: Any, solutions: Solutions) -> list[Comparison]:
        """Its rows.

        Raises:
            ValueError: for a row that the claim's name does not cover: nobody could ask for it.
        """
        found = self.rows(case, solutions)
        rows = [found] if isinstance(found, Comparison) else list(found)
        for row in rows:
            if not _meet(row.quantity, self.name):
                raise ValueError(f"the claim {self.name} returned the row {row.quantity!r}")
        return rows


@dataclass(frozen=True)
class Plan:
    """The plan of a study for given settings, data and seed.

    Attributes:
        source: the data.
        tasks: what is solved.
        exports: names of the problems, of those solved, whose best solution goes onto a machine.
        case: what the claims and figures are about: the study's own data.
        claims: what is compared, in the order of the rows.
        figures: the figures, given the case and all solutions.
        report: what a fit is worth; None for a published study.
        notes: what should be known before anything is solved, a sentence each.
        findings: numbers that people take from the run, given the case and all solutions.
        report_figures: the report's figures, given the case and all solutions; None: all figures.
        share: from the case and the URL of a database to the case whose own searches are shared.
        last: makes the searches of the case that come after the tasks.

    Raises:
        ValueError: where a problem is to be exported that nobody solves.
    """

    source: Source
    tasks: tuple[Task, ...]
    exports: tuple[str, ...]
    case: Any
    claims: tuple[Claim, ...]
    figures: Callable[[Any, Solutions], Iterable[Figure]]
    report: "Callable[[Any, Solutions], FitRecord] | None" = None
    notes: tuple[str, ...] = ()
    findings: Callable[[Any, Solutions], Iterable[Finding]] = no_findings
    report_figures: Callable[[Any, Solutions], Iterable[ReportFigure]] | None = None
    share: Callable[[Any, str], Any] = as_it_is
    last: Callable[[Any], None] = nothing_more

    def __post_init__(self) -> None:
        solved = {task.problem.name for task in self.tasks}
        for name in self.exports:
            if name not in solved:
                raise unknown("problem", name, solved)

    def only(self, names: Iterable[str]) -> "Plan":
        """The plan that tries some claims alone; nothing is exported or drawn.

        Args:
            names: of claims or of their rows, with * and ?.

        Raises:
            ValueError: for a claim that there is none of, with the near ones.
        """
        wanted = tuple(names)
        for name in wanted:
            if not any(_meet(claim.name, name) for claim in self.claims):
                raise unknown("claim", name, [claim.name for claim in self.claims])
        claims = tuple(claim for claim in self.claims if _among(claim.name, wanted))
        needs = tuple(need for claim in claims for need in claim.needs)
        tasks = tuple(task for task in self.tasks if _among(task.problem.name, needs))
        return Plan(self.source, tasks, (), self.case, claims, no_figures)

    def compare(
        self,
        solutions: Solutions,
        names: Iterable[str] = (),
        early: Mapping["Claim", Future[list[Comparison]]] | None = None,
    ) -> list[Comparison]:
        """The rows of all claims, or those of some names, with * and ?.

        Args:
            solutions: of the tasks.
            names: of the rows; none: all.
            early: claims that are being tried already.

        Raises:
            ValueError: for a name that no row has, with the near ones.
        """
        begun = early or {}
        rows: list[Comparison] = []
        for one in self.claims:
            found = begun.get(one)
            rows += one.compare(self.case, solutions) if found is None else found.result()
        wanted = tuple(names)
        for name in wanted:
            if not any(_meet(row.quantity, name) for row in rows):
                raise unknown("claim", name, [row.quantity for row in rows])
        return [row for row in rows if not wanted or _among(row.quantity, wanted)]


def no_figures(case: Any, solutions: Solutions) -> tuple[Figure, ...]:
    """Nothing is drawn."""
    return ()


def _among(name: str, others: tuple[str, ...]) -> bool:
    return any(_meet(name, other) for other in others)


def _meet(one: str, other: str) -> bool:
    """Whether there is a name that fits both; in either, * stands for any text, ? for a letter."""
    if not one or not other:
        return not one.strip("*") and not other.strip("*")
    if one[0] == "*":
        return _meet(one[1:], other) or _meet(one, other[1:])
    if other[0] == "*":
        return _meet(other, one)
    return (one[0] == other[0] or "?" in (one[0], other[0])) and _meet(one[1:], other[1:])


@dataclass(frozen=True)
class Study:
    """A published result to run again, or a benchmark.

    Attributes:
        name: what it is called on the command line.
        title: one line.
        paper: the citation.
        settings: the model of its options, a frozen pydantic model that forbids unknown names.
        plan: from settings, recordings (none: its own data), seed and database URL to the plan.
        channels: what ``--map`` may name, nothing for any name; None if it takes no recording.
        truths: what ``--truth`` may name.
        at_rate: from settings, what is exported, another rate and the parameters that are densities
            times the rate to the same filter at that rate; None where there is no other rate.
        needs: what it needs to be given, "" for nothing: it makes its own data.
        takes: about how long it takes on two processors, "" where that depends on what is given.
        faults: what is wrong with settings that are well formed, and with mappings of channels and
            of truths, a sentence each; None: that shows as it is planned.
    """

    name: str
    title: str
    paper: str
    settings: "type[BaseModel]"
    plan: "Callable[[Any, tuple[Record, ...], int, str], Plan]"
    channels: "Callable[[Any], Mapping[str, Channel]] | None" = None
    truths: "Callable[[Any], Mapping[str, Channel]] | None" = None
    at_rate: "Callable[[Any, Tuned, float, Collection[str]], AtRate] | None" = None
    faults: "Callable[[Any, Iterable[str], Iterable[str]], Iterable[str]] | None" = None
    needs: str = ""
    takes: str = ""


def study_names() -> list[str]:
    """The names of all installed studies, sorted; none of them is imported."""
    return names("tuner.studies")


def find_study(name: str) -> Study:
    """Load a study by name, from whichever installed package offers it.

    Raises:
        ValueError: for an unknown name, with the near ones, and for one that cannot be imported.

    >>> find_study("kownacki2010").paper.split(",")[0]
    'C. Kownacki'
    """
    study: Study = find("tuner.studies", name)
    return study
