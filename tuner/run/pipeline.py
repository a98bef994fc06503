"""From a study to a run's folder: solve, compare, export, read back, draw, write down."""

import io
import json
import time
from collections.abc import Callable, Mapping
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from typing import Any, TypeAlias

import numpy as np

from objectives import kind_of
from tuner import export
from tuner.atomic import WriteError
from tuner.certificate.single_precision import SinglePrecision
from tuner.certificate.solution import Solution
from tuner.data.source import Source
from tuner.export.tuned import Provenance, Tuned
from tuner.problem.problem import Problem
from tuner.report.report_json import Kept as ForReport
from tuner.report.report_json import kept_pictures, nothing_kept
from tuner.report.write import KEPT, PAGE, page_of
from tuner.run.background_work import (
    differentiate,
    import_report_packages,
    in_background,
    of_each_program,
)
from tuner.run.drawing import picture, table
from tuner.run.environment import environment
from tuner.run.figure import Figure
from tuner.run.fit_record import FitRecord
from tuner.run.folder import RunFolder
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
    CodeRecord,
    ExportRecord,
    Result,
    SingleRecord,
    SolutionRecord,
    pretty,
)
from tuner.run.shared_run import Together
from tuner.run.study import Plan, Solutions, Task, best
from tuner.run.threads import at_once

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called with what is being done, and how many of how many parts are finished."""

VERSIONS = ("filter-tuner", "jax", "numpy", "scipy", "optuna")


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
        self._save(solutions, digests)  # a run that is interrupted at once can go on as well
        with in_background(import_report_packages), at_once(jobs) as pool:
            for problem in of_each_program(task.problem for task in open_tasks):
                pool.submit(differentiate, problem)
            futures = {pool.submit(_solved, task): task for task in open_tasks}
            for future in as_completed(futures):
                task = futures[future]
                solutions[task_key(task)], digests[task_key(task)] = future.result()
                self._save(solutions, digests)
                words = f"{task.problem.name}: {task.solver.name}"
                self.progress(words, len(solutions), len(self.plan.tasks))
        return _agreement({task_key(task): solutions[task_key(task)] for task in self.plan.tasks})

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
        artifacts = ["study.toml", "environment.json"]
        exports: list[ExportRecord] = []
        codes: list[CodeRecord] = []
        singles: list[SingleRecord] = []
        found = [(problem, best(problem.name, solutions)) for problem in exported(self.plan)]
        tuned = [self.tuned(problem, solution) for problem, solution in found]
        with at_once(2) as pool:  # beside the comparisons: compilers free the interpreter
            made = [
                pool.submit(self._code, *one, what, formats)
                for one, what in zip(found, tuned, strict=True)
            ]
            checked = [pool.submit(_in_single_precision, *one) for one in found]
            self.progress("comparing", 0, 4)
            comparisons = self.plan.compare(solutions, self.claims)
            for k, (problem, solution) in enumerate(found):
                self.progress(f"exporting {tuned[k].name}", 1, 4)
                texts, more, written = made[k].result()
                if solution.status.trusted:
                    exports += [
                        self._export(problem, solution, tuned[k], f, texts) for f in formats
                    ]
                artifacts += more
                codes += written
                self.progress(f"single precision {tuned[k].name}", 2, 4)
                singles += checked[k].result()
        artifacts += [record.file for record in exports]
        if self.plan.report is not None:
            artifacts += [self._outputs(problem, solution) for problem, solution in found]
        figures, drawn, not_drawn = self._draw(solutions)
        artifacts += drawn
        result = Result(
            schema="tuner.result/1",
            study=self.study,
            seed=self.seed,
            log=self.plan.source,
            settings=self.settings,
            solutions=[SolutionRecord.of(solution) for solution in solutions.values()],
            comparisons=comparisons,
            exports=exports,
            single_precision=singles,
            tuned=[json.loads(export.dump(one, "json")) for one in tuned],
            artifacts=[*artifacts, KEPT, PAGE, "result.json"],
            seconds=time.perf_counter() - begun,
            fit=self._report(solutions),
            findings=list(self.plan.findings(self.plan.case, solutions)),
            code=codes,
            identity=dict(self.identity),
            not_drawn=not_drawn,
        )
        self.folder.write("result.json", result.to_json().encode())
        self._write_report(result, solutions, figures)
        self.folder.remove("progress.json")
        self.progress("done", 4, 4)
        return result

    def _draw(self, solutions: Solutions) -> tuple[list[Figure], list[str], list[str]]:
        """Figures, their files, and why others are missing: one that fails ends no run."""
        figures: list[Figure] = []
        files: list[str] = []
        failed: list[str] = []
        try:
            for figure in self.plan.figures(self.plan.case, solutions):
                self.progress(f"drawing {figure.name}", 3, 4)
                try:
                    made = {"csv": table(figure), "png": picture(figure)}
                except Exception as error:
                    failed.append(f"{figure.name} could not be drawn: {_said(error)}")
                    continue
                stem = f"figures/{figure.name}"
                files += [self.folder.write(f"{stem}.{end}", made[end]) for end in made]
                figures.append(figure)
        except WriteError:
            raise
        except Exception as error:
            failed.append(f"a figure could not be drawn: {_said(error)}")
        return figures, files, failed

    def _write_report(self, result: Result, solutions: Solutions, figures: list[Figure]) -> None:
        """The report, and what it takes to write it again."""
        self.progress("writing the report", 3, 4)
        shown = [ReportFigure("figures", figure) for figure in figures]
        if self.plan.shown is not None:
            shown = [*self.plan.shown(self.plan.case, solutions)]
        kept = self.kept.model_copy(update={"pictures": kept_pictures(shown)})
        self.folder.write(KEPT, kept.to_json())
        self.folder.write(PAGE, page_of(result, kept, self.folder.path))

    def _code(
        self, problem: Problem, solution: Solution, tuned: Tuned, formats: tuple[str, ...]
    ) -> tuple[dict[str, bytes], list[str], list[CodeRecord]]:
        """The headers with code, other files that were written, and what is told of them."""
        from tuner.run.machine import in_all_variants

        if "c" not in formats or not solution.status.trusted:
            return {}, [], []
        found, records = in_all_variants(tuned, problem.on_machine(solution))
        own = {name: data for name, data in found.items() if name == f"exports/{tuned.name}.h"}
        others = [name for name in found if name not in own]
        with at_once(len(others) or 1) as pool:  # each waits for the disk
            more = list(pool.map(lambda name: self.folder.write(name, found[name]), others))
        return own, more, records

    def _outputs(self, problem: Problem, solution: Solution) -> str:
        """The tuned filter's outputs over the recording, in full."""
        from filters.declared import bare, channel_facts, output
        from tuner.run.gate import SAID

        outputs = problem.outputs(solution)
        facts = channel_facts(bare(problem.filter), "outputs")
        found = {name: output(problem.filter, outputs, name) for name in facts}
        found |= {name: getattr(outputs, name) for name in SAID if hasattr(outputs, name)}
        arrays = {name: np.asarray(each) for name, each in found.items() if each is not None}
        stream = io.BytesIO()
        np.savez_compressed(stream, allow_pickle=False, **arrays)
        return self.folder.write("outputs.npz", stream.getvalue())

    def _report(self, solutions: Solutions) -> FitRecord | None:
        """The worth of a fit; None for a published study."""
        if self.plan.report is None:
            return None
        return self.plan.report(self.plan.case, solutions)

    def tuned(self, problem: Problem, solution: Solution) -> Tuned:
        """The exports of a problem: its parameters, and what follows from them."""
        return tuned_of(
            problem, solution, self.study, self.seed, problem.source or self.plan.source
        )

    def _export(
        self,
        problem: Problem,
        solution: Solution,
        tuned: Tuned,
        form: str,
        headers: Mapping[str, bytes],
    ) -> ExportRecord:
        name = f"exports/{tuned.name}{export.suffix(form)}"
        self.folder.write(name, headers.get(name) or export.dump(tuned, form))
        read_back = export.read_back(tuned, self.folder.path / name, form)
        return score_export(problem, solution.value, read_back, form, name)


def tuned_of(problem: Problem, solution: Solution, study: str, seed: int, source: Source) -> Tuned:
    """The exports of a solution: its parameters, what follows from them, and their origin."""
    what = problem.what_is_exported()
    return Tuned(
        name=solution.problem,
        filter=what.filter,
        quantities=problem.quantities(solution),
        convention="discrete" if what.dt else "continuous",
        dt=what.dt,
        states=what.states,
        provenance=Provenance(
            study=study,
            problem=solution.problem,
            solver=solution.solver,
            status=solution.status.value,
            seed=seed,
            log_name=source.name,
            log_sha256=source.sha256,
            versions=tuple((name, version(name)) for name in VERSIONS),
        ),
    )


def write_down(folder: RunFolder, recipe: Recipe, plan: Plan) -> None:
    """The recipe, and the environment it ran in."""
    folder.write("study.toml", recipe.to_toml())
    known = environment() | {"seed": recipe.seed, "log_sha256": plan.source.sha256}
    folder.write("environment.json", pretty(known))


def _in_single_precision(problem: Problem, solution: Solution) -> list[SingleRecord]:
    """The checks, or why there are none: a filter that cannot be checked ends no run."""
    try:
        checks = problem.single_precision(solution)
    except TypeError as error:
        said = f"single precision was not checked: {error}"
        checks = (SinglePrecision("full", "", np.inf, np.inf, 0, np.inf, said),)
    return [SingleRecord(problem=problem.name, **asdict(check)) for check in checks]


def score_export(
    problem: Problem, value: float, tuned: Tuned, form: str, file: str
) -> ExportRecord:
    """Score the parameters of an exported filter against the value of its solution."""
    parameters = {q.name: q.value for q in tuned.quantities if q.name in problem.space.names}
    score = problem.score(parameters)
    least = 1.0 if kind_of(problem.objective) == "likelihood" else 0.0  # nats are no share of 0
    change = (score - value) / (max(abs(value), least) or 1.0)
    return ExportRecord(
        problem=problem.name, format=form, file=file, score=score, relative_change=change
    )


def exported(plan: Plan) -> list[Problem]:
    """The problems of a plan whose solutions are exported, in the order it names them."""
    problems = {task.problem.name: task.problem for task in plan.tasks}
    return [p for name in plan.exports if isinstance(p := problems[name], Problem)]


def trusted(plan: Plan, solutions: Solutions) -> bool:
    """Whether every problem that is exported has a best solution that converged.

    Problems that are solved for the comparison alone may be ill posed; their rows say so.
    """
    return all(best(name, solutions).status.trusted for name in plan.exports)


def _begun(problem: Any) -> None:
    """Score a problem where searches begin; convex programs have no such place."""
    if isinstance(problem, Problem) and problem.space.size:
        problem.value(problem.space.start())


def _said(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def _solved(task: Task) -> tuple[Solution, str]:
    """The solution of a task, and the identity of its problem."""
    return task.solver(task.problem), problem_identity(task)


def _agreement(solutions: Solutions) -> dict[tuple[str, str], Solution]:
    """Tell every solution how the other methods did on its problem."""
    agreed = {}
    for key, own in solutions.items():
        others = [s for s in solutions.values() if s.problem == own.problem and s is not own]
        reached = {other.solver: other.value for other in others}
        agreed[key] = replace(own, certificate=replace(own.certificate, methods=reached))
    return agreed
