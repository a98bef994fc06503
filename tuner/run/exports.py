"""The files of a run's tuned filters: exports that are read back, C, outputs; and their checks."""

import io
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from typing import NamedTuple

import numpy as np

from objectives import kind_of
from tuner import export
from tuner.certificate.single_precision import SinglePrecision
from tuner.certificate.solution import Solution
from tuner.data.source import Source
from tuner.export.tuned import Provenance, Tuned
from tuner.problem.problem import Problem
from tuner.run.folder import RunFolder
from tuner.run.progress import Progress
from tuner.run.result import CodeRecord, ExportRecord, SingleRecord
from tuner.run.study import Plan

VERSIONS = ("filter-tuner", "jax", "numpy", "scipy", "optuna")


class TunedFilter(NamedTuple):
    """A problem, its best solution, and what is exported of it."""

    problem: Problem
    solution: Solution
    tuned: Tuned


@dataclass(frozen=True)
class Exports:
    """The exports of a run.

    Attributes:
        records: of the files of parameters, each read back and scored.
        code: of the C.
        single_precision: the checks in float32.
        others: files that hold C besides the parameters.
    """

    records: list[ExportRecord] = field(default_factory=list)
    code: list[CodeRecord] = field(default_factory=list)
    single_precision: list[SingleRecord] = field(default_factory=list)
    others: list[str] = field(default_factory=list)

    @property
    def files(self) -> list[str]:
        """All files that were written."""
        return [*self.others, *(record.file for record in self.records)]


class Code(NamedTuple):
    """The C of a tuned filter.

    Attributes:
        headers: of the parameters, by their file's name; still to be written.
        others: files that were written.
        records: what is told of them.
    """

    headers: dict[str, bytes]
    others: list[str]
    records: list[CodeRecord]


class PendingExport(NamedTuple):
    """An export whose C and checks are made in other threads."""

    filter: TunedFilter
    code: "Future[Code]"
    checks: "Future[list[SingleRecord]]"


def begin_exports(
    pool: Executor, folder: RunFolder, filters: list[TunedFilter], formats: tuple[str, ...]
) -> list[PendingExport]:
    """Begin to write the C of tuned filters, and to check them in single precision."""
    codes = [pool.submit(_write_code, folder, each, formats) for each in filters]
    checks = [pool.submit(_in_single_precision, each.problem, each.solution) for each in filters]
    return [PendingExport(*parts) for parts in zip(filters, codes, checks, strict=True)]


def write_exports(
    folder: RunFolder,
    pending: Iterable[PendingExport],
    formats: tuple[str, ...],
    progress: Progress,
) -> Exports:
    """Write tuned filters in all formats, of solutions that can be trusted."""
    exports = Exports()
    for each, making, checking in pending:
        progress(f"exporting {each.tuned.name}", 2, 4)
        code = making.result()
        if each.solution.status.trusted:
            exports.records.extend(_export(folder, each, formats, code.headers))
        exports.others.extend(code.others)
        exports.code.extend(code.records)
        progress(f"single precision {each.tuned.name}", 3, 4)
        exports.single_precision.extend(checking.result())
    return exports


def _write_code(folder: RunFolder, each: TunedFilter, formats: tuple[str, ...]) -> Code:
    """Write the C besides the header of the parameters."""
    from tuner.run.machine import in_all_variants

    if "c" not in formats or not each.solution.status.trusted:
        return Code({}, [], [])
    found, records = in_all_variants(each.tuned, each.problem.on_machine(each.solution))
    header = f"exports/{each.tuned.name}.h"
    headers = {name: data for name, data in found.items() if name == header}
    others = {name: text for name, text in found.items() if name not in headers}
    return Code(headers, folder.write_all(others), records)


def _export(
    folder: RunFolder, each: TunedFilter, formats: Iterable[str], headers: Mapping[str, bytes]
) -> Iterator[ExportRecord]:
    """Write a tuned filter in all formats, and read each back."""
    names = {f"exports/{each.tuned.name}{export.suffix(form)}": form for form in formats}
    folder.write_all(
        {name: headers.get(name) or export.dump(each.tuned, form) for name, form in names.items()}
    )
    for name, form in names.items():
        read_back = export.read_back(each.tuned, folder.path / name, form)
        yield score_export(each.problem, each.solution.value, read_back, form, name)


def write_outputs(folder: RunFolder, problem: Problem, solution: Solution) -> str:
    """Write the tuned filter's outputs over the recording, in full; return the file's name."""
    from filters.declared import bare, channel_facts, output
    from tuner.run.gate import SAID

    outputs = problem.outputs(solution)
    facts = channel_facts(bare(problem.filter), "outputs")
    found = {name: output(problem.filter, outputs, name) for name in facts}
    found |= {name: getattr(outputs, name) for name in SAID if hasattr(outputs, name)}
    arrays = {name: np.asarray(each) for name, each in found.items() if each is not None}
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=False, **arrays)
    return folder.write("outputs.npz", stream.getvalue())


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


def _in_single_precision(problem: Problem, solution: Solution) -> list[SingleRecord]:
    """The checks, or why there are none: a filter that cannot be checked ends no run."""
    try:
        checks = problem.single_precision(solution)
    except TypeError as error:
        note = f"single precision was not checked: {error}"
        checks = (SinglePrecision("full", "", np.inf, np.inf, 0, np.inf, note),)
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
