"""Tables for people, on stdout."""

import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill

from rich import box
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from tuner.certificate.solution import Status
from tuner.certificate.table import range_in_words
from tuner.cli.blocks import WIDE, blocks, broken, crowded, widths
from tuner.cli.width import piped_width, width_is_known
from tuner.names import counted
from tuner.report.lines import five_lines
from tuner.run.comparison import Verdict
from tuner.run.finding import Finding
from tuner.run.noise_table import COLUMNS
from tuner.run.result import CodeRecord, ParameterRecord, Result, SolutionRecord
from tuner.terminal_text import plain, printable

_COLOURS = {
    "match": "green",
    "claim holds": "green",
    "converged": "green",
    "differs": "yellow",
    "claim fails": "yellow",
    "not identifiable": "cyan",
    "inconsistent in the paper": "cyan",
}


@dataclass(frozen=True)
class _Safe:
    """A drawing without the control characters of its texts."""

    drawn: ConsoleRenderable

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Segment]:
        for part in console.render(self.drawn, options):
            yield part if part.control else Segment(printable(part.text), part.style)


class _AllSafe(RenderHook):
    """Has everything that a console prints made safe; only rich itself draws."""

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        """The same, made safe."""
        return [_Safe(each) for each in renderables]


def console() -> Console:
    """Standard output, as wide as it is told to be where it is no terminal."""
    stream = plain(sys.stdout)
    own = Console(file=stream, width=None if stream.isatty() else piped_width())
    own.push_render_hook(_AllSafe())
    return own


def number_text(value: float | None) -> str:
    """A number in six digits, a dash for none."""
    return "-" if value is None else f"{value:.6g}"


_EXPLANATIONS = {"where", "note", "what it means", "evaluations", "s"}
_NUMBER = re.compile(r"-?[\d.]+(e[-+]?\d+)?|-|inf|nan|")
_FOLDED = _EXPLANATIONS | {"parameters", "meaning", "smaller", "larger"}


def show_grid(title: str, lines: list[list[str]]) -> None:
    """Print a table: the first line heads it, verdicts are coloured, no number is ever cut.

    Where its words do not fit side by side, every line is a block of its own.
    """
    out = console()
    wide = out.width >= WIDE
    columns = [i for i, head in enumerate(lines[0]) if wide or head not in _EXPLANATIONS]
    left = [head for head in lines[0] if not wide and head in _EXPLANATIONS]
    lines = [[line[i] for i in columns] for line in lines]
    if crowded(lines, out.width):
        out.print(blocks(title, lines, out.width), soft_wrap=True, markup=False, highlight=False)
    else:
        out.print(_table(title, lines, out.width))
    if left:
        out.print(f"(from {WIDE} columns on: {', '.join(left)})\n", markup=False, highlight=False)


def _table(title: str, lines: list[list[str]], width: int) -> Table:
    wide = width >= WIDE
    table = Table(
        title=title,
        title_justify="left",
        header_style="bold",
        box=box.SQUARE if wide else None,
        pad_edge=False,
    )
    given: list[int | None] = [None] * len(lines[0]) if wide else [*widths(lines, width)]
    for own, (head, *cells) in zip(given, zip(*lines, strict=True), strict=True):
        numbers = all(_NUMBER.fullmatch(cell) for cell in cells)
        folded = head in _FOLDED or max(map(len, cells), default=0) > width // 3
        fixed = numbers or (wide and not folded)
        least = max(map(len, [head, *cells])) if numbers else None
        table.add_column(head, overflow="fold", no_wrap=fixed, min_width=least, width=own)
    for line in lines[1:]:
        cells = [c if w is None else broken(c, w) for c, w in zip(line, given, strict=True)]
        styles = [_COLOURS.get(cell, "") for cell in line]
        table.add_row(*(Text(printable(c), s) for c, s in zip(cells, styles, strict=True)))
    return table


LONG = 40
"""Of more rows than this a run shows those alone that somebody has to look at."""


def show_result(result: Result, folder: Path, *, whole: bool = True) -> None:
    """Print solutions, what is flat, the comparison, single precision and where the files are.

    Args:
        result: what was found.
        folder: where its files are.
        whole: whether all rows are shown, also of a long result.
    """
    long = not whole and len(result.solutions) + len(result.comparisons) > LONG
    names = {tuned["name"] for tuned in result.tuned}
    solutions = [s for s in result.solutions if not long or s.problem in names]
    rows = [r for r in result.comparisons if not long or r.verdict not in _MET]
    if solutions:
        show_grid("Solutions", [_SOLUTIONS, *(_solution(solution) for solution in solutions)])
    lines = [
        [r.quantity, r.where, number_text(r.paper), number_text(r.ours), r.verdict.value, r.note]
        for r in rows
    ]
    if lines:
        head = ["quantity", "where", "paper", "ours", "verdict", "note"]
        show_grid("Comparison", [head, *lines])
    out = console()
    if long:
        left = len(result.solutions) - len(solutions), len(result.comparisons) - len(rows)
        searches = "1 search" if left[0] == 1 else f"{left[0]} searches"
        out.print(f"not shown: {searches}, {counted(left[1], 'row')} met; tuner show {folder}")
    show_findings(result.findings)
    for export in result.exports:
        if abs(export.relative_change or 0.0) > 1e-12:
            out.print(f"{export.file}: read back and scored, cost {export.relative_change:+.1e}")
    if result.exports:
        out.print(f"{len(result.exports)} exports, each read back, compared and scored again")
    for line in _in_c(result.code):
        out.print(line, soft_wrap=not width_is_known(), markup=False, highlight=False)
    for check in result.single_precision:
        share = "without bound" if check.share is None else f"by {100 * check.share:.2g} %"
        text = f"in single precision the {check.form} form strays {share}{_of(check.output)}"
        out.print(
            f"{check.problem}: {check.warning or text}", style="yellow" if check.warning else ""
        )
    where = f"all files are in {folder}; the report is {folder / 'report.html'}"
    out.print(f"{result.seconds:.1f} s; {where}", soft_wrap=True, markup=False)
    for line in five_lines(result):
        text = re.sub(r"\bRUN\b", lambda _: str(folder), line)
        if width_is_known() and not text.startswith("next"):  # that one is copied
            text = fill(text, out.width, subsequent_indent=" " * 10, break_on_hyphens=False)
        out.print(text, soft_wrap=True, highlight=False, markup=False)  # intervals are no markup


_SOLUTIONS = [
    *("problem", "solver", "status", "value", "parameters", "evaluations", "s", "what it means"),
]


def _in_c(codes: list[CodeRecord]) -> Iterator[str]:
    """The size of each filter in C, a line each."""
    for problem in dict.fromkeys(code.problem for code in codes):
        own = [code for code in codes if code.problem == problem]
        good = [code for code in own if not code.refused]
        if not good:
            yield f"{problem}: no C, {own[0].refused}"
            continue
        sizes = [
            f"{c.code_bytes} bytes of code and {c.stack_bytes} of stack as {c.precision}"
            for c in good
            if c.code_bytes is not None
        ]
        facts = "; ".join([f"{good[0].operations} operations a sample", *sizes])
        machine = " on this machine" if sizes else ""
        yield f"{problem} in C ({good[0].file}): {facts}{machine}"
        yield from (f"{problem}: no C in {c.precision}, {c.refused}" for c in own if c.refused)


def show_findings(findings: Iterable[Finding]) -> None:
    """Print numbers that were found; noises with variance, density and deviation side by side."""
    rest = list(findings)
    noises = _noises(rest)
    if noises:
        head = ["noise", "variance a sample", "density", "deviation", "in data sheet units"]
        used = len(head) if any(line[-1] for line in noises.values()) else len(head) - 1
        show_grid("Noise", [line[:used] for line in (head, *noises.values())])
    lines = [
        [f.name, number_text(f.value), f.limits, f.unit, f.meaning]
        for f in rest
        if f.name.partition(".")[0] not in noises
    ]
    if lines:
        show_grid("Found", [["name", "value", "95 % limits", "unit", "meaning"], *lines])


def _noises(findings: list[Finding]) -> dict[str, list[str]]:
    """A line for every noise of which there are a variance and a deviation."""
    own: dict[str, dict[str, Finding]] = {}
    for found in findings:
        name, _, part = found.name.partition(".")
        own.setdefault(name, {})[part] = found
    return {
        name: [name, *(_amount(parts.get(column)) for column in COLUMNS), _sheet(parts)]
        for name, parts in own.items()
        if {"variance", "deviation"} <= parts.keys()
    }


def _sheet(parts: dict[str, Finding]) -> str:
    """The findings that are not side by side, each with its name where the unit does not say it."""
    more = {part: found for part, found in parts.items() if part not in COLUMNS}
    lines = [_amount(f) if part == f.unit else f"{part} {_amount(f)}" for part, f in more.items()]
    return "\n".join(lines)


def _amount(finding: Finding | None) -> str:
    return "" if finding is None else f"{number_text(finding.value)} {finding.unit}".rstrip()


def _of(output: str) -> str:
    """Of which output."""
    return f" of the output {output!r}" if output else " of the signal"


def _solution(solution: SolutionRecord) -> list[str]:
    certificate = solution.certificate
    # Where constraints hold a solution, a parameter without a range is held, not undetermined;
    # and where nobody looked at second derivatives, nobody knows.
    held = any(certificate.get("multipliers", {}).values())
    unknown = not (certificate["curvatures"] or certificate["active_bounds"])
    tuned = set() if held or unknown else {label.split()[-1] for label in certificate["gradient"]}
    values = [
        f"{name} = {_parameter(p, tuned=name in tuned)}"
        for name, p in solution.parameters.items()
        if isinstance(p.value, float)
    ]
    return [
        solution.problem,
        solution.solver,
        solution.status.value,
        number_text(solution.value),
        "\n".join(values),
        str(solution.evaluations),
        f"{solution.seconds:.1f}",
        "; ".join(_meaning(solution)),
    ]


_MET = (Verdict.MATCH, Verdict.HOLDS)
_EXISTENCE = (Status.INFEASIBLE, Status.UNBOUNDED, Status.UNATTAINED)


def _meaning(solution: SolutionRecord) -> list[str]:
    """The parameters that are not determined, proofs, and why there is no optimum."""
    certificate = solution.certificate
    words = [solution.message] if solution.status in _EXISTENCE else []
    words += certificate["flat_directions"]
    bound = certificate.get("lower_bound")
    words += [] if bound is None else [f"proved: no value is below {number_text(bound)}"]
    multipliers = certificate.get("multipliers", {}).items()
    words += [f"limited by {name} ({m:.3g})" for name, m in multipliers if m and m > SLIGHT]
    words += ["gradients by compiled C"] if solution.gradient_by.startswith("C, ") else []
    return [*words, *_starts(solution)]


SLIGHT = 1e-6
"""A multiplier below this is not worth a word."""


def _parameter(parameter: ParameterRecord, *, tuned: bool) -> str:
    """A parameter with its range; what was tuned and has none is not determined."""
    text = f"{parameter.value:.5g}"
    if parameter.interval:
        text += f" {range_in_words(parameter.interval, parameter.interval_kind)}"
    return f"{text} {parameter.unit}" + (
        " (not determined)" if tuned and not parameter.interval else ""
    )


def _starts(solution: SolutionRecord) -> list[str]:
    starts = solution.certificate["starts"]
    return (
        [f"{starts['agreeing']} of {starts['count']} starts agree"] if starts["count"] > 1 else []
    )
