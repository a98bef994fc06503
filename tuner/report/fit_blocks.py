"""The blocks of a fit's report: signal, innovations, identifiability."""

from collections.abc import Iterator, Sequence

from tuner.report.answer import follows
from tuner.report.blocks import Block, Listed, Table, Words
from tuner.report.pictures import pictures
from tuner.report.report_json import Kept
from tuner.report.verdict import main_solution, worth
from tuner.report.words import amount, interval, number, sentence
from tuner.run.finding import Finding
from tuner.run.fit_record import DiagnosticsRecord
from tuner.run.result import Result

FEW = 6
"""Rows of a table of side results that need not be folded."""


def signal(result: Result, kept: Kept) -> Iterator[Block]:
    """The measurements and the filter's estimates."""
    shown = [*pictures(kept, "signal")]
    if shown and result.fit is not None:
        yield Words([worth(result.fit)])
    yield from shown


def innovations(result: Result, kept: Kept) -> Iterator[Block]:
    """Whether the filter is right about what it does not predict."""
    fit = result.fit
    if fit is None or len(fit.diagnostics) != 2:
        return
    before, now = fit.diagnostics
    failed = [found for found in now.findings if found.verdict == "failed"]
    yield Words([_nis(now, before)])
    if failed:
        yield Listed([sentence(found.sentence) for found in failed])
    if fit.rejected is not None:
        share = f"{fit.rejected.rejected} of {fit.rejected.numbers}"
        verb = "given little weight" if fit.rejected.weighed else "rejected"
        yield Words(
            [f"{share} measurements were {verb}; {fit.rejected.outside} lie outside the gate."]
        )
    yield from pictures(kept, "innovations")
    yield _tests(before, now)


def _nis(now: DiagnosticsRecord, before: DiagnosticsRecord) -> str:
    if now.nis is None:
        return "The filter predicts no variance, so its consistency cannot be tested."
    inside = now.low is not None and now.high is not None and now.low <= now.nis <= now.high
    words = "as large as the filter says" if inside else "not as large as the filter says"
    return (
        f"The innovations are {words}: their NIS is {number(now.nis, 3, zeros=True)}, and "
        f"{interval((now.low, now.high))} is expected; before it was "
        f"{number(before.nis, 3, zeros=True)}."
    )


def _tests(before: DiagnosticsRecord, now: DiagnosticsRecord) -> Table:
    was = {found.test: found.verdict for found in before.findings}
    rows = [
        [found.test, found.verdict, was.get(found.test, ""), found.what,
         number(found.statistic, 3), number(found.p, 2)]
        for found in now.findings
    ]  # fmt: skip
    head = ["test", "tuned", "before", "statistic", "value", "p-value"]
    return Table("Tests of the innovations", head, rows, frozenset((4, 5)), 1)


def determined(result: Result, kept: Kept) -> Iterator[Block]:
    """The parameters that the data determine, and the consequences."""
    solution = main_solution(result)
    if result.fit is not None and solution is not None:
        flat = [*solution.certificate["flat_directions"]]
        held = [
            f"{label.split()[-1]} lies at its bound"
            for label in solution.certificate["active_bounds"]
        ]
        notes = [note for note in kept.notes if "determined" in note]
        sentences = list(dict.fromkeys([*flat, *held, *notes]))
        if sentences:
            yield Listed([sentence(each) for each in sentences])
        else:
            yield Words(["Everything that was tuned is determined by this recording."])
    yield from pictures(kept, "certificate")
    yield from _noise(result.findings)
    yield from _found(result.findings, {name for name, _, _ in follows(result)})


def _noise(findings: Sequence[Finding]) -> Iterator[Block]:
    own: dict[str, dict[str, Finding]] = {}
    for found in findings:
        name, _, part = found.name.partition(".")
        own.setdefault(name, {})[part] = found
    parts = ("variance", "density", "deviation")
    lines = {n: each for n, each in own.items() if {"variance", "deviation"} <= each.keys()}
    if lines:
        rows = [
            [name, *(_amount(each.get(part)) for part in parts)] for name, each in lines.items()
        ]
        head = ["noise", "variance a sample", "density", "deviation"]
        yield Table("Each noise in common units", head, rows, frozenset((1, 2, 3)))


def _found(findings: Sequence[Finding], answered: set[str]) -> Iterator[Block]:
    noises = {f.name.partition(".")[0] for f in findings if f.name.endswith(".deviation")}
    rest = [f for f in findings if f.name.partition(".")[0] not in noises | answered]
    if rest:
        rows = [[f.name, _amount(f), _limits(f), f.meaning] for f in rest]
        head = ["name", "value", "95 % limits", "what it is"]
        yield Table("What follows", head, rows, frozenset((1, 2)), folded=len(rows) > FEW)


def _amount(finding: Finding | None) -> str:
    return "" if finding is None else amount(finding.value, finding.unit, 5)


def _limits(finding: Finding) -> str:
    if finding.low is None and finding.high is None:
        return ""
    return interval((finding.low, finding.high))
