"""Text logs: CSV, TXT and TSV, plain or gzip-compressed."""

import csv
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

import numpy as np

from tuner.data.logs.error import LogError, counted
from tuner.data.logs.layout import Layout, is_content, is_number, open_text, read_layout, split
from tuner.data.logs.table import Floats, Raw, Table

_BLOCK = 8192


def open_csv(path: Path) -> Table:
    """Open a text log with or without a header.

    The delimiter (tab, semicolon, comma or blanks) is found from the first lines; lines that
    start with ``#`` or ``%`` are comments. Nameless columns are called column1, column2, ...
    It is compressed where its bytes say so.

    Raises:
        LogError: where the file is damaged, is no text or holds no numbers; loading raises it
            for ragged rows and for text in a column of numbers.
    """
    with _damage_told(path):
        layout = read_layout(path)

    def load(names: Sequence[str]) -> dict[str, Raw]:
        with _damage_told(path):
            columns = [layout.names.index(name) for name in names]
            values = _fast(layout, columns)
            if values is None:
                values = _careful(layout, columns)
            return dict(zip(names, values, strict=True))

    def place(row: int) -> str:
        return f"line {_line_number(layout, row)}"

    def labels(name: str) -> Raw:
        with _damage_told(path):
            return _words(layout, layout.names.index(name))

    return Table(path.name, layout.names, load, place, True, layout.texts, labels)


@contextmanager
def _damage_told(path: Path) -> Iterator[None]:
    """Turn what a damaged file raises into a sentence."""
    try:
        yield
    except (OSError, EOFError, zlib.error, csv.Error) as error:
        raise LogError(
            f"{path.name}: the file cannot be read ({error}); copy or export it again"
        ) from error


def _fast(layout: Layout, columns: list[int]) -> list[Floats] | None:
    """The columns by numpy's reader; None where it cannot take the file as a whole."""
    if layout.texts or layout.comma:
        return None
    with open_text(layout.path) as stream:
        lines = islice(filter(is_content, stream), layout.above, None)
        try:
            table = np.loadtxt(
                lines,
                delimiter=layout.delimiter,
                comments=None,
                quotechar='"',
                ndmin=2,
            )
        except ValueError:
            return None
    if table.shape[1] != len(layout.names):
        return None
    return [np.ascontiguousarray(table[:, column]) for column in columns]


def _careful(layout: Layout, columns: list[int]) -> list[Floats]:
    """The columns cell by cell: slower, but able to skip text columns and to say what is wrong."""
    parts: list[list[Floats]] = [[] for _ in columns]
    with open_text(layout.path) as stream:
        lines = islice(filter(is_content, stream), layout.above, None)
        rows = split(lines, layout.delimiter)
        start = 0
        while block := list(islice(rows, _BLOCK)):
            _check_widths(layout, start, block)
            for part, column in zip(parts, columns, strict=True):
                part.append(_numbers(layout, start, [row[column] for row in block], column))
            start += len(block)
    return [np.concatenate(part) for part in parts]


def _words(layout: Layout, column: int) -> Raw:
    """One column as it is written."""
    with open_text(layout.path) as stream:
        lines = islice(filter(is_content, stream), layout.above, None)
        rows = split(lines, layout.delimiter)
        return np.array([row[column].strip() for row in rows if len(row) > column])


def _check_widths(layout: Layout, start: int, block: list[list[str]]) -> None:
    width = len(layout.names)
    if set(map(len, block)) == {width}:
        return
    row = next(i for i, cells in enumerate(block) if len(cells) != width)
    raise LogError(
        f"{layout.path.name}: line {_line_number(layout, start + row)} has "
        f"{counted(len(block[row]), 'cell')} instead of {width}; complete the line or remove it"
    )


def _numbers(layout: Layout, start: int, cells: list[str], column: int) -> Floats:
    """One block of one column; an empty cell is a missing value, NaN."""
    if layout.comma:
        cells = [cell.replace(",", ".") for cell in cells]
    try:
        return np.array([float(cell.strip() or "nan") for cell in cells])
    except ValueError:
        wrong = next(i for i, cell in enumerate(cells) if cell.strip() and not is_number(cell))
    raise LogError(
        f"{layout.path.name}: line {_line_number(layout, start + wrong)}, column "
        f"{layout.names[column]!r} holds {_told(cells[wrong])}, not a number; "
        f"{_way_out(cells[wrong])}"
    )


def _told(cell: str) -> str:
    return repr(cell if len(cell) <= 40 else cell[:37] + "...")


def _way_out(cell: str) -> str:
    if is_number(cell.replace(",", ".")):
        return "export the log with decimal points, since a comma may mean thousands"
    return "correct it, remove the line, make it a comment with # or map another column"


def _line_number(layout: Layout, row: int) -> int:
    """The line of a row of numbers, counted from 1; read again, since only errors ask for it."""
    with open_text(layout.path) as stream:
        numbers = (number for number, line in enumerate(stream, 1) if is_content(line))
        return next(islice(numbers, row + layout.above, None), row + 1)
