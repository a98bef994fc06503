"""The layout of a text log: its lines, its delimiter and the names of its columns."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from tuner.data.logs.cells import decimal_mark, is_number
from tuner.data.logs.error import LogError, quoted
from tuner.data.logs.heading import (
    Head,
    check_names,
    commented_names,
    first_row,
    holds_values,
    is_header,
    names_above,
    present,
    unique,
    units_note,
)
from tuner.data.logs.kinds import Chosen, Lines, kinds_of
from tuner.data.logs.moments import is_moment
from tuner.data.logs.stream import Encoding, is_content, read_head, split
from tuner.names import counted

_WIDEST = 100_000
_DELIMITERS = "\t;,|"
_SAMPLE = 300
_FEW = 20
_T = TypeVar("_T")


@dataclass(frozen=True)
class Layout:
    """The layout of a text log, known before its numbers are read.

    Attributes:
        path: the file.
        encoding: its character encoding.
        delimiter: one character, or None where blanks separate the cells.
        names: the columns, each name once.
        above: number of lines above the first row of numbers, including blank ones and comments.
        heads: those of them that are neither; a repetition of one is not a row.
        point: the decimal mark of its numbers.
        moments: the columns that hold dates or times of day.
        texts: the columns that hold other text.
        words: the words in them, among the first rows, and their columns.
        units: those in a row below the names, by column.
        notes: remarks on the layout.
        chosen: the rows to read; None for all.
    """

    path: Path
    encoding: Encoding
    delimiter: str | None
    names: tuple[str, ...]
    above: int
    heads: frozenset[bytes]
    point: str = "."
    moments: frozenset[str] = frozenset()
    texts: frozenset[str] = frozenset()
    words: Mapping[str, int] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    chosen: Chosen | None = None


def read_layouts(path: Path) -> dict[str, Layout]:
    """The layout of a text log from its first lines, or one for each kind of rows.

    Raises:
        LogError: where the file is no text or holds no numbers.
    """
    start, encoding = read_head(path)
    every = start.decode(encoding.letters, "replace").split("\n")
    held = [number for number, line in enumerate(every) if is_content(line)]
    lines = Lines(held, [every[number] for number in held])
    delimiter = _delimiter(lines.texts)
    kinds = kinds_of(path, encoding, delimiter, lines) if delimiter else {}
    if not kinds:
        return {"": _read_layout(path, encoding, delimiter, every, lines)}
    found = {}
    others: dict[str, Lines] = {}
    for chosen, part in kinds.items():
        try:
            found[chosen.word] = _read_layout(path, encoding, delimiter, [], part, chosen)
        except LogError:
            others[chosen.word] = part
    if not found:
        raise LogError(f"{path.name}: there is not one row of numbers in it; record the log again")
    titles = [
        (number, cells)
        for part in others.values()
        for number, cells in zip(part.numbers, split(part.texts, delimiter), strict=True)
        if is_header(cells)
    ]
    note = f"rows of {quoted(others)} left out: no numbers" if others else ""
    return {word: _titled(layout, titles, note) for word, layout in found.items()}


def _titled(layout: Layout, titles: list[tuple[int, list[str]]], note: str) -> Layout:
    """The layout with the names in a line of another kind above, where it has none of its own."""
    width = len(layout.names)
    fits = [cells for number, cells in titles if number < layout.above and len(cells) == width]
    nameless = layout.names == unique([""] * width)
    names = unique(fits[-1]) if fits and nameless else layout.names
    return replace(layout, names=names, notes=(*layout.notes, *([note] if note else [])))


def _read_layout(
    path: Path,
    encoding: Encoding,
    delimiter: str | None,
    every: list[str],
    lines: Lines,
    chosen: Chosen | None = None,
) -> Layout:
    """The layout of rows of one kind."""
    cells = list(split(lines.texts, delimiter))
    width = _width(_end(cells))
    if width > _WIDEST:
        raise LogError(f"{path.name}: its rows have {width} cells; at most {_WIDEST} are read")
    head = Head(lines.numbers, cells, width, *_columns(_end(cells), width)[:2])
    first = first_row(head)
    if first is None:
        raise LogError(f"{path.name}: there is not one row of numbers in it; record the log again")
    sample = [row for row in cells[first:][-_SAMPLE:] if len(row) == width]
    point, values, note = _columns(sample, width)
    if chosen is None:
        check_names(path.name, head, first)
    named, units, titles = names_above(head, first)
    if named is None:
        named = commented_names(every[: lines.numbers[first]], delimiter, width)
    names = unique(named)
    units_of = {names[k]: unit for k, unit in enumerate(units) if unit}
    texts = [k for k in range(width) if k not in values and present(sample, k)]
    times = {k for k in values if not any(map(is_number, present(sample, k)))}
    notes = (
        encoding.note,
        f"{counted(titles, 'line')} above the columns left out" * bool(titles and chosen is None),
        "decimal commas" * (point == ","),
        note,
        units_note(units_of),
    )
    return Layout(
        path=path,
        encoding=encoding,
        delimiter=delimiter,
        names=names,
        above=lines.numbers[first],
        heads=frozenset(text.encode(encoding.letters, "replace") for text in lines.texts[:first]),
        point=point,
        moments=frozenset(names[k] for k in times if any(map(is_moment, present(sample, k)))),
        texts=frozenset(names[k] for k in texts),
        words={cell.strip(): k for k in texts for cell in present(cells[first:], k)},
        units=units_of,
        notes=tuple(filter(None, notes)),
        chosen=chosen,
    )


def _delimiter(lines: list[str]) -> str | None:
    """The delimiter of most lines at the end; any other goes before a possible decimal comma."""
    lines = list(_end(lines))
    for delimiter in _DELIMITERS:
        if 2 * sum(delimiter in line for line in lines) > len(lines):
            return None if delimiter == "," and _blanks_fit_better(lines) else delimiter
    return None


def _blanks_fit_better(lines: list[str]) -> bool:
    """Whether the cells between blanks are numbers with decimal commas."""
    cells = [line.split() for line in lines]
    return all(len(row) > 1 for row in cells) and all(
        is_number(cell.replace(",", ".", 1)) and cell == cell.strip(",")
        for row in cells
        for cell in row
    )


def _end(rows: Sequence[_T]) -> Sequence[_T]:
    """Some rows at the end, where there are numbers and no headings."""
    return rows[len(rows) // 2 :][-_FEW:]


def _columns(rows: Sequence[list[str]], width: int) -> tuple[str, tuple[int, ...], str]:
    """The decimal mark of rows, the columns of numbers or times, and notes."""
    fitting = [row for row in rows if len(row) == width]
    point, note = decimal_mark(cell for row in fitting for cell in row)
    columns = ([row[k] for row in fitting] for k in range(width))
    return point, tuple(k for k, cells in enumerate(columns) if holds_values(cells, point)), note


def _width(rows: Sequence[list[str]]) -> int:
    """The most frequent number of cells in a row."""
    counts = Counter(map(len, rows))
    return max(counts, key=lambda width: (counts[width], width), default=0)
