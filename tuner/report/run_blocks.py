"""The blocks of any run's report: comparison, searches, data, files and commands."""

import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path

from tuner.names import counted
from tuner.report.answer import searched
from tuner.report.blocks import Block, Commands, Listed, Table, Words
from tuner.report.pictures import pictures
from tuner.report.report_json import Kept
from tuner.report.verdict import main_solution
from tuner.report.words import amount, label, number, percent, sentence, size, unit
from tuner.run.comparison import Comparison
from tuner.run.result import Result, SingleRecord, SolutionRecord

SHORT = 12
"""Letters of a checksum that are shown."""
NAMED = 8
"""Parameters of a search that are named one by one."""
ROUNDING = 1e-12
"""A value that is off by this share or less is the same, added up in another order."""
_FORMATS = (("c", "C for the machine"), ("json", "or toml, npz, csv, mat"))


def rows(result: Result) -> Iterator[Block]:
    """A paper's numbers and claims beside those of this run."""
    found = result.comparisons
    if not found:
        return
    some = any(row.paper is not None for row in found)
    head = ["quantity", "verdict", *(["reference"] if some else []), "this run"]
    rows_ = [_row(row, some) for row in found]
    yield Table("Numbers and claims", head, rows_, frozenset((2, 3)), 1)


def _row(row: Comparison, some: bool) -> list[str]:
    """A quantity and its place in the paper, one below the other; and both numbers."""
    about = "\n".join(part for part in (row.quantity, label(row.where), label(row.note)) if part)
    paper, ours = ("" if v is None else amount(v, row.unit, 5) for v in (row.paper, row.ours))
    return [about, row.verdict.value, *([paper] if some else []), ours]


def search(result: Result, kept: Kept) -> Iterator[Block]:
    """Every search, and how it ended."""
    if not result.solutions:
        return
    solution = main_solution(result)
    if result.fit is not None and solution is not None:
        yield Words([_ended(solution)])
    head = [
        "problem",
        "solver",
        "how it ended",
        "value",
        "parameters",
        "starts agree",
        "evaluations",
        "time",
    ]
    rows = [_solution(each) for each in result.solutions]
    yield Table("All searches", head, rows, frozenset((3, 5, 6, 7)), 2)
    yield from _recordings(result)
    yield from pictures(kept, "search")


def _ended(solution: SolutionRecord) -> str:
    starts = solution.certificate["starts"]
    agree = f"; {starts['agreeing']} of {starts['count']} starts agree"
    return sentence(
        f"after {counted(solution.evaluations, 'evaluation')} {solution.solver} ended "
        f"{solution.status.value!r}: {solution.status.sentence}{agree * (starts['count'] > 1)}"
    )


def _solution(solution: SolutionRecord) -> list[str]:
    starts = solution.certificate["starts"]
    values = [
        f"{name} = {amount(p.value, p.unit)}"
        for name, p in searched(solution).items()
        if isinstance(p.value, float)
    ]
    more = f" and {len(values) - NAMED} more" if len(values) > NAMED else ""
    return [
        solution.problem,
        solution.solver,
        solution.status.value,
        number(solution.value, 6),
        ", ".join(values[:NAMED]) + more,
        f"{starts['agreeing']} of {starts['count']}" if starts["count"] > 1 else "",
        str(solution.evaluations),
        f"{solution.seconds:.1f} s",
    ]


def _recordings(result: Result) -> Iterator[Block]:
    held = None if result.fit is None else result.fit.held_out
    if held is None or not held.recordings:
        return
    rows = [
        [str(each.recording), *(number(value) for value in (each.start, each.tuned, each.best))]
        for each in held.recordings
    ]
    head = ["recording", "before", "tuned on the others", "tuned on it"]
    yield Table("Each recording, held out in turn", head, rows, frozenset((0, 1, 2, 3)))


def data(result: Result, kept: Kept) -> Iterator[Block]:
    """The data that were read."""
    log = result.log
    digest = f"SHA-256 {log.sha256[:SHORT]}…"
    if log.samples and not kept.records:
        rate = f" at {number(log.rate_hz)} Hz" if log.rate_hz else ""
        yield Words([f"{log.name}: {counted(log.samples, 'sample')}{rate}, {digest}"])
    several = len(kept.records) > 1
    for number_, record in enumerate(kept.records, 1):
        about = record.about if several else [*record.about, digest]
        if about:
            yield Listed(about)
        if record.rows:
            head, *given = record.rows
            rows = [
                [
                    unit(cell) if name == "unit" else cell
                    for name, cell in zip(head, row, strict=True)
                ]
                for row in given
            ]
            title = f"Channels of recording {number_}" if several else "Channels"
            yield Table(title, head, rows, frozenset(range(3, len(head))))
    if kept.recordings > len(kept.records) > 0:
        yield Words([f"and {counted(kept.recordings - len(kept.records), 'more recording')}"])
    rest = [note for note in kept.notes if "determined" not in note or result.fit is None]
    if rest:
        yield Listed([sentence(note) for note in rest])


def files(result: Result, folder: Path) -> Iterator[Block]:
    """The exports, and their deviation from the tuned filter."""
    if result.exports:
        rows = [
            [
                record.file,
                record.format,
                _size(folder / record.file),
                _deviation(record.relative_change),
            ]
            for record in result.exports
        ]
        head = ["file", "format", "size", "value after reading back"]
        yield Table("Exports, each read back and evaluated again", head, rows, frozenset((2,)))
    good = [code for code in result.code if not code.refused]
    if good:
        rows = [
            [
                *(c.problem, c.precision, c.file, ", ".join(c.forms), str(c.operations)),
                *(_bytes(c.code_bytes), _bytes(c.stack_bytes)),
            ]
            for c in good
        ]
        head = ["filter", "precision", "file", "forms", "operations a sample", "code", "stack"]
        yield Table("C code of the filter", head, rows, frozenset((4, 5, 6)))
    refused = [f"{c.problem} in {c.precision}: no C, {c.refused}" for c in result.code if c.refused]
    checks = [sentence(_single(check)) for check in result.single_precision]
    if refused or checks:
        yield Listed([*map(sentence, refused), *checks])


def _size(file: Path) -> str:
    try:
        return size(file.stat().st_size)
    except OSError:
        return "not here"


def _bytes(count: int | None) -> str:
    return "" if count is None else size(count)


def _deviation(change: float | None) -> str:
    return "the same" if abs(change or 0.0) < ROUNDING else f"{number(change, 2)} off"


def _single(check: SingleRecord) -> str:
    if check.warning:
        return f"{check.problem}: {check.warning}"
    where = f"the output {check.output}" if check.output else "the signal"
    share = "without bound" if check.share is None else f"by {percent(check.share)}"
    return f"{check.problem}: in single precision the {check.form} form strays {share} of {where}"


def again(result: Result, folder: Path) -> Iterator[Block]:
    """Commands that go on from here."""
    name = shlex.quote(folder.name or "RUN")
    yield Words(
        ["The folder of this report contains everything needed; recordings are expected beside it."]
    )
    lines = [f"tuner run {name}/study.toml --out again", f"tuner show {name}"]
    if result.fit is not None:
        lines.append(f"tuner check {name} --log ANOTHER.csv    # these values on another recording")
    lines += [f"tuner export {name} --to {f}    # {words}" for f, words in _FORMATS if result.tuned]
    yield Commands(lines)
    yield Words([_versions(result)])


def _versions(result: Result) -> str:
    versions: Mapping[str, str] = result.tuned[0].get("versions", {}) if result.tuned else {}
    packages = ", ".join(f"{name} {version}" for name, version in versions.items())
    return sentence(
        f"seed {result.seed}; {number(result.seconds, 3)} s" + (f"; {packages}" if packages else "")
    )
