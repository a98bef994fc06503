"""The lines above the numbers of a text log: titles, names and units."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from tuner.data.logs.cells import is_missing, is_number, read_cell
from tuner.data.logs.error import LogError
from tuner.data.logs.moments import is_moment
from tuner.data.logs.stream import split
from tuner.data.logs.timename import UNITS
from tuner.data.units import Unit

_BRACKETS = {"[": "]", "(": ")", "<": ">", "{": "}"}


@dataclass(frozen=True)
class Head:
    """The first lines with content: their numbers in the file from 0, and their cells."""

    lines: list[int]
    rows: list[list[str]]
    width: int
    point: str
    values: tuple[int, ...]

    def filled(self, row: list[str]) -> float:
        """The share of the columns of numbers and times that hold one; 0 in another width."""
        if len(row) != self.width:
            return 0.0
        return sum(is_value(row[k], self.point) for k in self.values) / len(self.values)


def present(rows: list[list[str]], column: int) -> list[str]:
    """The nonempty cells of a column."""
    return [row[column] for row in rows if column < len(row) and not is_missing(row[column])]


def is_value(cell: str, point: str) -> bool:
    """Whether a cell is a number, a time, or a mark for a missing one."""
    return read_cell(cell, point) is not None or is_moment(cell)


def holds_values(cells: list[str], point: str) -> bool:
    """Whether more than half of a column's nonempty cells are numbers or times."""
    written = [cell for cell in cells if not is_missing(cell)]
    return 2 * sum(is_value(cell, point) for cell in written) > len(written)


def first_row(head: Head) -> int | None:
    """The first row of numbers; one that is damaged must not pass for names."""
    if not head.values:
        return None
    full = (k for k, row in enumerate(head.rows) if head.filled(row) == 1.0)
    first = next(full, None)
    while first and head.filled(head.rows[first - 1]) >= 0.5:
        first -= 1
    return first


def names_above(head: Head, first: int) -> tuple[list[str] | None, list[str], int]:
    """The names above the first row, the units between them, and the number of other lines."""
    above = [_fitted(head, row) for row in head.rows[max(first - 2, 0) : first]]
    last = above[-1] if above else None
    if last is None or not is_header(last):
        return None, [], first
    upper = above[0] if len(above) == 2 else None
    if upper is not None and is_header(upper) and all(map(str.strip, upper)) and _are_units(last):
        return upper, [_unit(cell) or "" for cell in last], first - 2
    return last, [], first - 1


def _fitted(head: Head, row: list[str]) -> list[str] | None:
    """A row of the same width as those of numbers, except for a delimiter at the end."""
    if len(row) == head.width + 1 and not row[-1].strip():
        return row[:-1]
    if len(row) == head.width - 1 and head.width - 1 not in head.values:
        return [*row, ""]
    return row if len(row) == head.width else None


def check_names(file: str, head: Head, first: int) -> None:
    """Refuse a row of names right above the numbers that are too few or too many."""
    row = head.rows[first - 1] if first else []
    doubled = 2 * len(row) == head.width
    if len(row) < 2 or not (doubled or abs(len(row) - head.width) == 1):
        return
    if _fitted(head, row) is None and all(map(str.strip, row)) and is_header(row):
        way_out = "complete the names or take them out"
        if doubled:
            way_out = "a comma that is the decimal mark too needs another delimiter"
        raise LogError(
            f"{file}: line {head.lines[first - 1] + 1} names {len(row)} columns, and the rows "
            f"below have {head.width} cells; {way_out}"
        )


def is_header(cells: list[str]) -> bool:
    """A header holds text and not one number: a damaged first row must not pass for one."""
    return any(not is_missing(cell) for cell in cells) and not any(map(is_number, cells))


def _are_units(cells: list[str]) -> bool:
    """Whether most nonempty cells of a row are units."""
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


def units_note(units: Mapping[str, str]) -> str:
    """The units below the names in words."""
    text = ", ".join(f"{name} {unit}" for name, unit in list(units.items())[:12])
    return f"units as the row below the names says: {text}" if text else ""


def commented_names(above: list[str], delimiter: str | None, width: int) -> list[str]:
    """Names from the comment right above the numbers (as numpy.savetxt writes them)."""
    comments = [line.strip().lstrip("#%") for line in above if line.strip()]
    cells = next(split(comments[-1:], delimiter), [])
    return cells if len(cells) == width and is_header(cells) else [""] * width


def unique(cells: list[str]) -> tuple[str, ...]:
    """Names without blanks around them; nameless and repeated ones get their number."""
    names = [cell.strip() or f"column{number}" for number, cell in enumerate(cells, 1)]
    counts = Counter(names)
    return tuple(
        name if counts[name] == 1 else f"{name} (column {number})"
        for number, name in enumerate(names, 1)
    )
