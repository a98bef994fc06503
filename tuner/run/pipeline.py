"""From a study to a run's folder: solve, compare, export, read back, draw, write down."""

import json
import time
from collections.abc import Mapping
from concurrent.futures import Future, as_completed
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

from tuner import export
from tuner.certificate.solution import Solution
from tuner.export.tuned import Tuned
from tuner.problem.problem import Problem
from tuner.processors import beside_others
from tuner.report.report_json import Kept as ForReport
from tuner.report.report_json import KeptChart, KeptMap, kept_pictures, nothing_kept
from tuner.report.write import KEPT, PAGE, page_of
from tuner.run.background_work import (
    begin_claims,
    begin_gradients,
    compile_checks,
    compile_gradients,
    compile_self_tests,
    import_report_packages,
    in_background,
)
from tuner.run.comparison import Comparison
from tuner.run.environment import environment
from tuner.run.exports import (
    TunedFilter,
    begin_exports,
    exported,
    tuned_of,
    write_exports,
    write_outputs,
)
from tuner.run.figure import Figure
from tuner.run.figure_files import draw_figures
from tuner.run.finding import Finding
from tuner.run.fit_record import FitRecord
from tuner.run.folder import RunFolder
from tuner.run.painter import Painter
from tuner.run.progress import Progress
from tuner.run.progress_file import (
    SCHEMA,
    Finished,
    ProgressFile,
    check_solution,
    problem_identity,
    task_key,
)
from tuner.run.recipe import Recipe
from tuner.run.report_figure import ReportFigure
from tuner.run.result import (
    Result,
    SolutionRecord,
    pretty,
)
from tuner.run.shared_run import Together
from tuner.run.study import Claim, Plan, Solutions, Task, best
from tuner.run.threads import at_once


class _Told(NamedTuple):
    """What a run tells of its solutions.

    Attributes:
        fit: the worth of a fit; None for a published study.
        findings: the noise and the gains.
        pictures: of its report.
    """

    fit: FitRecord | None
    findings: list[Finding]
    pictures: list[KeptChart | KeptMap]


@dataclass(frozen=True)
class Run:
    """A study or a fit under way.

    Attributes:
        study: its name.
        settings: its settings, as JSON-able values.
        plan: what it does.
        seed: where its random numbers come from.
        folder: where its files go.
        progress: told of every part.
        claims: names of the claims that are asked for; all if empty.
        identity: of the run; see :mod:`tuner.run.identity`.
        kept: what its report tells of the study and of the recordings.
        painter: draws its figures.
        early: claims that are tried while the searches run.
    """

    study: str
    settings: dict[str, Any]
    plan: Plan
    seed: int
    folder: RunFolder
    progress: Progress
    claims: tuple[str, ...] = ()
    identity: Mapping[str, str] = field(default_factory=dict)
    kept: ForReport = field(default_factory=nothing_kept)
    painter: Painter = field(default_factory=Painter)
    early: dict[Claim, Future[list[Comparison]]] = field(default_factory=dict)

    def check(self, jobs: int) -> None:
        """Find what would be refused before anything is written: score where each search begins.

        Raises:
            ValueError: for a solver that cannot take its problem, and for a problem that cannot be
                scored.
        """
        self.progress("scoring", 0, 1)
        for task in self.plan.tasks:
            if hasattr(task.solver, "check"):
                task.solver.check(task.problem)
        problems = {id(task.problem): task.problem for task in self.plan.tasks}
        begin_gradients(problems.values())
        with at_once(jobs) as pool:
            for _ in pool.map(_begun, problems.values()):
                self.progress("scoring", 0, 1)

    def solve(self, jobs: int, finished: Mapping[tuple[str, str], Solution]) -> Solutions:
        """Solve all tasks that are not finished yet, in several threads.

        Every solution is written to ``progress.json`` at once, so that an interrupted run can go
        on. Threads suffice: the time is spent in compiled code, which frees the interpreter.
        """
        solutions, digests = dict(finished), dict[tuple[str, str], str]()
        open_tasks = [task for task in self.plan.tasks if task_key(task) not in solutions]
        self.progress("solving", len(solutions), len(self.plan.tasks))
        with in_background(self._prepare), at_once(jobs) as pool:
            compile_gradients(pool, (task.problem for task in open_tasks))
            several = jobs > 1 and len(open_tasks) > 1
            futures = {pool.submit(_solved, task, several): task for task in open_tasks}
            if jobs > 1:
                self.early.update(begin_claims(self.plan))
            self._save(solutions, digests)  # a run that is interrupted at once can go on as well
            for future in as_completed(futures):
                task = futures[future]
                solutions[task_key(task)], digests[task_key(task)] = future.result()
                self._save(solutions, digests)
                words = f"{task.problem.name}: {task.solver.name}"
                self.progress(words, len(solutions), len(self.plan.tasks))
        return _agreement({task_key(task): solutions[task_key(task)] for task in self.plan.tasks})

    def _prepare(self) -> None:
        """Import and compile what the end of the run takes."""
        self.painter.begin(2 if self.plan.report is None else 1)  # a fit draws few
        import_report_packages()
        if self.plan.report is None:  # a fit has compiled its own as it was planned
            problems = exported(self.plan)
            for compile_one in (compile_checks, compile_self_tests):
                for problem in problems:
                    compile_one(problem)

    def solve_together(self, together: Together, finished: Solutions) -> Solutions:
        """Solve all tasks beside other processes; what they found is scored again here.

        Raises:
            ValueError: for a solution of another process that is none of the problem, or a refusal.
        """
        checked, digests = dict(finished), dict[tuple[str, str], str]()
        problems = {task_key(task): task.problem for task in self.plan.tasks}
        self._save(checked, digests)

        def news(solutions: Solutions) -> None:
            for key, solution in solutions.items():
                if key not in checked:
                    check_solution(problems[key], solution)
                    checked[key] = solution
                    self._save(checked, digests)
            self.progress("solving", len(checked), len(self.plan.tasks))

        together.work(news)
        return _agreement({task_key(task): checked[task_key(task)] for task in self.plan.tasks})

    def _save(self, solutions: Solutions, digests: dict[tuple[str, str], str]) -> None:
        for task in self.plan.tasks:
            if task_key(task) in solutions and task_key(task) not in digests:
                digests[task_key(task)] = problem_identity(task)
        finished = [
            Finished(identity=digests[key], solution=SolutionRecord.of(solution))
            for key, solution in solutions.items()
        ]
        kept = ProgressFile(schema=SCHEMA, identity=dict(self.identity), finished=finished)
        self.folder.write("progress.json", kept.to_json().encode(), replace=True)

    def finish(self, solutions: Solutions, formats: tuple[str, ...], begun: float) -> Result:
        """Compare, export, check in single precision and draw; write the result."""
        found = [(problem, best(problem.name, solutions)) for problem in exported(self.plan)]
        tuned = [TunedFilter(*each, self.tuned(*each)) for each in found]
        outputs: list[str] = []
        # Beside comparisons and figures: compilers free the interpreter.
        with at_once(2) as pool:
            pending = begin_exports(pool, self.folder, tuned, formats)
            self.progress("comparing", 0, 4)
            comparisons = self.plan.compare(solutions, self.claims, self.early)
            if self.plan.report is not None:
                outputs = [write_outputs(self.folder, *each) for each in found]
            figures = partial(self.plan.figures, self.plan.case, solutions)
            drawn = draw_figures(self.folder, figures, self.progress, self.painter)
            self.painter.end()
            told = self._told(solutions, drawn.figures)
            exports = write_exports(self.folder, pending, formats, self.progress)
        files = (*exports.files, *outputs, *drawn.files, KEPT, PAGE)
        result = Result(
            schema="tuner.result/1",
            study=self.study,
            seed=self.seed,
            log=self.plan.source,
            settings=self.settings,
            solutions=[SolutionRecord.of(solution) for solution in solutions.values()],
            comparisons=comparisons,
            exports=exports.records,
            single_precision=exports.single_precision,
            tuned=[json.loads(export.dump(each.tuned, "json")) for each in tuned],
            artifacts=["study.toml", "environment.json", *files, "result.json"],
            seconds=time.perf_counter() - begun,
            fit=told.fit,
            findings=told.findings,
            code=exports.code,
            identity=dict(self.identity),
            not_drawn=drawn.failed,
        )
        self.folder.write("result.json", result.to_json().encode())
        self._write_report(result, told.pictures)
        self.folder.remove("progress.json")
        self.progress("done", 4, 4)
        return result

    def _told(self, solutions: Solutions, figures: list[Figure]) -> _Told:
        """What solutions are worth, and the pictures of the report; of figures that were drawn."""
        shown = [ReportFigure("figures", figure) for figure in figures]
        if self.plan.report_figures is not None:
            shown = [*self.plan.report_figures(self.plan.case, solutions)]
        return _Told(
            fit=None if self.plan.report is None else self.plan.report(self.plan.case, solutions),
            findings=list(self.plan.findings(self.plan.case, solutions)),
            pictures=kept_pictures(shown),
        )

    def _write_report(self, result: Result, pictures: list[KeptChart | KeptMap]) -> None:
        """The report, and what it takes to write it again."""
        self.progress("writing the report", 3, 4)
        kept = self.kept.model_copy(update={"pictures": pictures})
        page = page_of(result, kept, self.folder.path)
        self.folder.write_all({KEPT: kept.to_json(), PAGE: page})

    def tuned(self, problem: Problem, solution: Solution) -> Tuned:
        """The exports of a problem: its parameters, and what follows from them."""
        return tuned_of(
            problem, solution, self.study, self.seed, problem.source or self.plan.source
        )


def write_down(folder: RunFolder, recipe: Recipe, plan: Plan) -> None:
    """The recipe, and the environment it ran in."""
    folder.write("study.toml", recipe.to_toml())
    known = environment() | {"seed": recipe.seed, "log_sha256": plan.source.sha256}
    folder.write("environment.json", pretty(known))


def trusted(plan: Plan, solutions: Solutions) -> bool:
    """Whether every problem that is exported has a best solution that converged.

    Problems that are solved for the comparison alone may be ill posed; their rows say so.
    """
    return all(best(name, solutions).status.trusted for name in plan.exports)


def _begun(problem: Any) -> None:
    """Score a problem where searches begin; convex programs have no such place."""
    if isinstance(problem, Problem) and problem.space.size:
        problem.value(problem.space.start())


def _solved(task: Task, several: bool) -> tuple[Solution, str]:
    """The solution of a task, which may be one of several; and the identity of its problem."""
    with beside_others() if several else nullcontext():
        return task.solver(task.problem), problem_identity(task)


def _agreement(solutions: Solutions) -> dict[tuple[str, str], Solution]:
    """The solutions, each with what the other methods reached on its problem."""
    agreed = {}
    for key, own in solutions.items():
        others = [s for s in solutions.values() if s.problem == own.problem and s is not own]
        reached = {other.solver: other.value for other in others}
        agreed[key] = replace(own, certificate=replace(own.certificate, methods=reached))
    return agreed
