"""Rows of the table of results, and the table on a terminal, in Markdown and as JSON."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from rich.console import Console
from rich.table import Table

HEADER = ("what", "ours", "against", "figure", "at best", "target", "reached")
NARROW = 0.15  # what a figure moves from run to run on a machine with other work


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        part: its heading.
        what: the measured quantity.
        ours: our time, in words.
        against: what it is compared with, in words.
        figure: the number that has the target; None where it could not be measured.
        best: the same from the shortest times.
        unit: of both; "x" is a ratio.
        target: None where there is none.
        sense: whether the target is the most or the least the figure may be.
        note: further findings.
        why: why a target is out of reach, for where it is missed.
    """

    part: str
    what: str
    ours: str = ""
    against: str = ""
    figure: float | None = None
    best: float | None = None
    unit: str = "x"
    target: float | None = None
    sense: Literal["most", "least"] = "most"
    note: str = ""
    why: str = ""

    @property
    def reached(self) -> bool | None:
        """Whether the figure is within its target; None where one of them is missing."""
        if self.figure is None or self.target is None:
            return None
        most = self.sense == "most"
        return self.figure <= self.target if most else self.figure >= self.target

    @property
    def narrow(self) -> bool:
        """Whether another run may well fall on the other side of the target."""
        timed = self.unit in ("x", "ns", "us", "ms", "s")
        if not timed or self.figure is None or self.target is None:
            return False
        return abs(self.figure / self.target - 1) < NARROW

    @property
    def cells(self) -> tuple[str, ...]:
        """The row as text."""
        sign = "<=" if self.sense == "most" else ">="
        target = "" if self.target is None else f"{sign} {self.with_unit(self.target)}"
        said = {True: "yes", False: "no", None: "" if self.target is None else "not measured"}
        judged = said[self.reached] + (", narrowly" if self.narrow else "")
        figure, best = (self.with_unit(value) for value in (self.figure, self.best))
        return self.what, self.ours, self.against, figure, best, target, judged

    def with_unit(self, value: float | None) -> str:
        """A number of the figure's kind as text; nothing for None."""
        return "" if value is None else f"{number(value)} {self.unit}".strip()


def number(value: float) -> str:
    """Three digits, without an exponent where a person would write none.

    >>> number(1.2345), number(1234.5), number(2.5e-11)
    ('1.23', '1230', '2.5e-11')
    """
    if value == 0 or not 1e-3 <= abs(value) < 1e6:
        return f"{value:.3g}"
    return f"{float(f'{value:.3g}'):g}" if abs(value) < 1000 else f"{float(f'{value:.3g}'):.0f}"


def duration(seconds: float) -> str:
    """A time in its natural unit.

    >>> duration(0.00178), duration(1.6)
    ('1.78 ms', '1.6 s')
    """
    if seconds >= 1:
        return f"{number(seconds)} s"
    return f"{number(1e3 * seconds)} ms" if seconds >= 1e-4 else f"{number(1e6 * seconds)} us"


def parts(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """The rows by heading, in order."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.part, []).append(row)
    return found


def show(rows: Sequence[Row], console: Console) -> None:
    """One table a heading, on a terminal."""
    for part, members in parts(rows).items():
        table = Table(*HEADER, title=part, title_justify="left")
        for row in members:
            colour = {True: "green", False: "yellow", None: ""}[row.reached]
            table.add_row(*row.cells[:-1], f"[{colour}]{row.cells[-1]}[/]" if colour else "")
        console.print(table)
        for row in members:
            if row.note:
                console.print(f"  {row.what}: {row.note}", markup=False, highlight=False)


def markdown(rows: Sequence[Row]) -> str:
    """The same in Markdown."""
    blocks = []
    for part, members in parts(rows).items():
        lines = [
            _line(HEADER),
            _line(("---",) * len(HEADER)),
            *(_line(row.cells) for row in members),
        ]
        notes = [f"- {row.what}: {row.note}" for row in members if row.note]
        blocks.append("\n".join([f"### {part}", "", *lines, *(["", *notes] if notes else [])]))
    return "\n\n".join(blocks)


def as_json(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The rows as they are, and whether each target was reached."""
    return [asdict(row) | {"reached": row.reached} for row in rows]


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
