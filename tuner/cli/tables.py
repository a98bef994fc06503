"""Tables for people, on stdout."""

from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from tuner.result import ParameterRecord, Result, SolutionRecord

_COLOURS = {
    "match": "green",
    "claim holds": "green",
    "converged": "green",
    "differs": "yellow",
    "claim fails": "yellow",
    "not identifiable": "cyan",
    "inconsistent in the paper": "cyan",
}


def console() -> Console:
    """Standard output; 150 columns where it is no terminal."""
    plain = Console()
    return plain if plain.is_terminal else Console(width=150)


def number_text(value: float | None) -> str:
    """A number in six digits, a dash for none."""
    return "-" if value is None else f"{value:.6g}"


def show_grid(title: str, lines: list[list[str]]) -> None:
    """Print a table: the first line heads it, verdicts are coloured."""
    table = Table(title=title, title_justify="left", header_style="bold", pad_edge=False)
    for head in lines[0]:
        wide = head in {"note", "where", "what it means"}
        table.add_column(head, overflow="fold", ratio=None, no_wrap=not wide)
    for line in lines[1:]:
        table.add_row(*(Text(cell, style=_COLOURS.get(cell, "")) for cell in line))
    console().print(table)


def show_result(result: Result, folder: Path) -> None:
    """Print solutions, what is flat, the comparison, single precision and where the files are."""
    head = [
        "problem",
        "solver",
        "status",
        "value",
        "parameters",
        "evaluations",
        "s",
        "what it means",
    ]
    show_grid("Solutions", [head, *(_solution(solution) for solution in result.solutions)])
    rows = [
        [r.quantity, r.where, number_text(r.paper), number_text(r.ours), r.verdict.value, r.note]
        for r in result.comparisons
    ]
    show_grid(
        "Comparison with the paper",
        [["quantity", "where", "paper", "ours", "verdict", "note"], *rows],
    )
    out = console()
    for export in result.exports:
        if abs(export.relative_change or 0.0) > 1e-12:
            out.print(f"{export.file}: read back and scored, cost {export.relative_change:+.1e}")
    if result.exports:
        out.print(f"{len(result.exports)} exports, each read back and scored again")
    for check in result.single_precision:
        if check.warning:
            out.print(f"[yellow]{check.problem}: {check.warning}[/]")
    out.print(f"{result.seconds:.1f} s; results, exports and figures in {folder}", soft_wrap=True)


def _solution(solution: SolutionRecord) -> list[str]:
    free = {n: p for n, p in solution.parameters.items() if isinstance(p.value, float)}
    return [
        solution.problem,
        solution.solver,
        solution.status.value,
        number_text(solution.value),
        "\n".join(f"{name} = {_parameter(p)}" for name, p in free.items()),
        str(solution.evaluations),
        f"{solution.seconds:.1f}",
        "; ".join([*solution.certificate["flat_directions"], *_starts(solution)]),
    ]


def _parameter(parameter: ParameterRecord) -> str:
    between = ""
    if parameter.interval:
        between = f" [{parameter.interval[0]:.3g}, {parameter.interval[1]:.3g}]"
    return f"{parameter.value:.5g}{between} {parameter.unit}"


def _starts(solution: SolutionRecord) -> list[str]:
    starts = solution.certificate["starts"]
    return (
        [f"{starts['agreeing']} of {starts['count']} starts agree"] if starts["count"] > 1 else []
    )
