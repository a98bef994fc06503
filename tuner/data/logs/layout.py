"""How a text log is laid out: its lines, its delimiter and the names of its columns."""

import csv
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tuner.data.logs.cells import decimal_mark, is_missing, is_number, read_cell
from tuner.data.logs.error import LogError, counted, suggest
from tuner.data.logs.moments import is_moment
from tuner.data.logs.stream import Encoding, read_head
from tuner.data.logs.timename import UNITS
from tuner.data.units import Unit

_WIDEST = 100_000
_DELIMITERS = "\t;,|"
_SAMPLE = 300
_BRACKETS = {"[": "]", "(": ")", "<": ">", "{": "}"}


@dataclass(frozen=True)
class Chosen:
    """The rows that hold a word in a column.

    Attributes:
        column: its number, from 0.
        word: what it holds.
    """

    column: int
    word: str

    def holds(self, cells: Sequence[str]) -> bool:
        """Whether a row is meant."""
        return len(cells) > self.column and cells[self.column].strip() == self.word


@dataclass(frozen=True)
class Layout:
    """What is known of a text log before its numbers are read.

    Attributes:
        path: the file.
        encoding: how its letters are written.
        delimiter: one character, or None where blanks separate the cells.
        names: the columns, each name once.
        above: how many lines stand above the first row of numbers, blank ones and comments too.
        heads: those of them that are neither; where one comes again, it is no row.
        point: the decimal mark.
        moments: the columns that hold dates or times of day.
        texts: the columns that hold other text.
        units: what a row below the names says, by column.
        notes: what was found.
        chosen: which rows are meant; None for all.
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
    units: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    chosen: Chosen | None = None


@dataclass(frozen=True)
class _Head:
    """The first lines with content: their numbers in the file from 0, and their cells."""

    lines: list[int]
    texts: list[str]
    rows: list[list[str]]
    width: int
    point: str
    values: tuple[int, ...]

    def filled(self, row: list[str]) -> float:
        """The share of the columns of numbers and times that hold one; 0 in another width."""
        if len(row) != self.width:
            return 0.0
        return sum(_is_value(row[k], self.point) for k in self.values) / len(self.values)


def is_content(line: str) -> bool:
    """Whether a line is neither blank nor a comment; a tab alone may separate empty cells."""
    text = line.strip(" \r\n")
    return bool(text) and text[0] not in "#%"


def split(lines: Iterable[str], delimiter: str | None) -> Iterator[list[str]]:
    """The cells of each line."""
    if delimiter is None:
        return (line.split() for line in lines)
    readers = (csv.reader([line], delimiter=delimiter, skipinitialspace=True) for line in lines)
    return (cells for reader in readers for cells in reader)


def read_layout(
    path: Path, decimal: str | None = None, rows: tuple[str, str] | None = None
) -> Layout:
    """Look at the first lines of a text log.

    Args:
        path: the file.
        decimal: the decimal mark; None finds it.
        rows: a column, by its name or number, and the word in it that chooses the rows; None
            takes all.

    Raises:
        LogError: where the file is no text, holds no numbers, or no such rows.
    """
    start, encoding = read_head(path)
    lines = start.decode(encoding.letters, "replace").split("\n")
    numbers = [number for number, line in enumerate(lines) if is_content(line)]
    texts = [lines[number] for number in numbers]
    delimiter = _delimiter(texts)
    cells = list(split(texts, delimiter))
    chosen = None
    if rows is not None:
        chosen, kept = _chosen(path, cells, *rows)
        numbers, texts, cells = ([part[k] for k in kept] for part in (numbers, texts, cells))
    width = _width(cells)
    if width > _WIDEST:
        raise LogError(f"{path.name}: its rows have {width} cells; at most {_WIDEST} are read")
    lower = cells[len(cells) // 2 :]
    sample = [row for row in lower[-_SAMPLE:] if len(row) == width]
    point, note = decimal_mark(cell for row in sample for cell in row)
    point, note = (decimal, "") if decimal else (point, note)
    values = tuple(k for k in range(width) if _holds_values([row[k] for row in sample], point))
    head = _Head(numbers, texts, cells, width, point, values)
    first = _first_row(head)
    if first is None:
        raise LogError(f"{path.name}: there is not one row of numbers in it; record the log again")
    if chosen is None:
        _check_names(path, head, first)
    named, units, titles = _names(head, first)
    if named is None:
        named = _commented_names(lines[: numbers[first]], delimiter, width)
    names = _unique(named)
    told = {names[k]: unit for k, unit in enumerate(units) if unit}
    times = {k for k in values if not any(map(is_number, _present(sample, k)))}
    notes = (
        encoding.told,
        f"{counted(titles, 'line')} above the columns left out" * bool(titles),
        "decimal commas" * (point == ","),
        note,
        _units_told(told),
    )
    return Layout(
        path=path,
        encoding=encoding,
        delimiter=delimiter,
        names=names,
        above=numbers[first],
        heads=frozenset(text.encode(encoding.letters, "replace") for text in texts[:first]),
        point=point,
        moments=frozenset(names[k] for k in times if any(map(is_moment, _present(sample, k)))),
        texts=frozenset(names[k] for k in range(width) if k not in values and _present(sample, k)),
        units=told,
        notes=tuple(filter(None, notes)),
        chosen=chosen,
    )


def _chosen(path: Path, rows: list[list[str]], column: str, word: str) -> tuple[Chosen, list[int]]:
    """The rows with a word in a column, those of the names before them."""
    top = next((k for k, row in enumerate(rows) if column in map(str.strip, row)), -1)
    if top >= 0:
        index = [cell.strip() for cell in rows[top]].index(column)
    elif column.isdecimal() and int(column) > 0:
        index = int(column) - 1
        top = 0 if _is_header(rows[0]) and len(rows[0]) > 1 else -1
    else:
        raise LogError(f"{path.name}: --rows {column}={word}: there is no column {column!r}")
    chosen = Chosen(index, word)
    found = [k for k, row in enumerate(rows) if k > top and chosen.holds(row)]
    if not found:
        words = dict.fromkeys(row[index].strip() for row in rows[top + 1 :] if len(row) > index)
        raise LogError(
            f"{path.name}: --rows {column}={word}: no row has {word!r} there; "
            f"{suggest(word, list(words))}"
        )
    return chosen, [*range(top + 1), *found]


def _delimiter(lines: list[str]) -> str | None:
    """What most lines of the lower half hold; a decimal comma yields to all others."""
    lines = lines[len(lines) // 2 :]
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


def _width(rows: Sequence[Sequence[str]]) -> int:
    """How many cells most rows of the lower half have."""
    counts = Counter(map(len, rows[len(rows) // 2 :]))
    return max(counts, key=lambda width: (counts[width], width), default=0)


def _present(rows: list[list[str]], column: int) -> list[str]:
    return [row[column] for row in rows if not is_missing(row[column])]


def _is_value(cell: str, point: str) -> bool:
    return read_cell(cell, point) is not None or is_moment(cell)


def _holds_values(cells: list[str], point: str) -> bool:
    """Whether a column holds numbers or times: more than half of what is written in it."""
    present = [cell for cell in cells if not is_missing(cell)]
    return 2 * sum(_is_value(cell, point) for cell in present) > len(present)


def _first_row(head: _Head) -> int | None:
    """The first row of numbers; one that is damaged must not pass for names."""
    if not head.values:
        return None
    full = (k for k, row in enumerate(head.rows) if head.filled(row) == 1.0)
    first = next(full, None)
    while first and head.filled(head.rows[first - 1]) >= 0.5:
        first -= 1
    return first


def _names(head: _Head, first: int) -> tuple[list[str] | None, list[str], int]:
    """The names above the first row, the units between them, and how many lines are neither."""
    above = [_fitted(head, row) for row in head.rows[max(first - 2, 0) : first]]
    last = above[-1] if above else None
    if last is None or not _is_header(last):
        return None, [], first
    upper = above[0] if len(above) == 2 else None
    if upper is not None and _is_header(upper) and all(map(str.strip, upper)) and _are_units(last):
        return upper, [_unit(cell) or "" for cell in last], first - 2
    return last, [], first - 1


def _fitted(head: _Head, row: list[str]) -> list[str] | None:
    """A row as wide as those of numbers, but for a delimiter at its end or at theirs."""
    if len(row) == head.width + 1 and not row[-1].strip():
        return row[:-1]
    if len(row) == head.width - 1 and head.width - 1 not in head.values:
        return [*row, ""]
    return row if len(row) == head.width else None


def _check_names(path: Path, head: _Head, first: int) -> None:
    """Refuse a row of names right above the numbers that are too few or too many."""
    row = head.rows[first - 1] if first else []
    doubled = 2 * len(row) == head.width
    if len(row) < 2 or not (doubled or abs(len(row) - head.width) == 1):
        return
    if _fitted(head, row) is None and all(map(str.strip, row)) and _is_header(row):
        way_out = "complete the names or take them out"
        if doubled:
            way_out = "a comma that is the decimal mark too needs another delimiter"
        raise LogError(
            f"{path.name}: line {head.lines[first - 1] + 1} names {len(row)} columns, and the rows "
            f"below have {head.width} cells; {way_out}"
        )


def _is_header(cells: list[str]) -> bool:
    """A header holds text and not one number: a damaged first row must not pass for one."""
    return any(not is_missing(cell) for cell in cells) and not any(map(is_number, cells))


def _are_units(cells: list[str]) -> bool:
    """Whether most of what is written in a row are units."""
    written = [cell for cell in cells if cell.strip()]
    return 2 * sum(_unit(cell) is not None for cell in written) > len(written)


def _unit(cell: str) -> str | None:
    """The unit in a cell, with or without brackets."""
    text = cell.strip()
    if len(text) > 1 and _BRACKETS.get(text[0]) == text[-1]:
        text = text[1:-1].strip()
    if text.lower() in UNITS:
        return text
    try:
        return Unit.of(text).name.strip() if text else None
    except ValueError:
        return None


def _units_told(units: Mapping[str, str]) -> str:
    told = ", ".join(f"{name} {unit}" for name, unit in list(units.items())[:12])
    return f"units as the row below the names says: {told}" if told else ""


def _commented_names(above: list[str], delimiter: str | None, width: int) -> list[str]:
    """Names from the comment right above the numbers (as numpy.savetxt writes them)."""
    comments = [line.strip().lstrip("#%") for line in above if line.strip()]
    cells = next(split(comments[-1:], delimiter), [])
    return cells if len(cells) == width and _is_header(cells) else [""] * width


def _unique(cells: list[str]) -> tuple[str, ...]:
    """Names without blanks around them; nameless and repeated ones tell their number."""
    names = [cell.strip() or f"column{number}" for number, cell in enumerate(cells, 1)]
    counts = Counter(names)
    return tuple(
        name if counts[name] == 1 else f"{name} (column {number})"
        for number, name in enumerate(names, 1)
    )
