"""Blocks of a text log as columns of numbers."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.data.logs.block import INSIDE, Block, read_rows
from tuner.data.logs.cells import read_cell
from tuner.data.logs.compiled import Form, reader
from tuner.data.logs.error import LogError
from tuner.data.logs.layout import Layout
from tuner.data.logs.scaling import Floats
from tuner.data.logs.table import Raw

_KNOWN = 10_000
_SHOWN = 40
_FEW = 1 << 16


@dataclass(frozen=True, eq=False)
class Part:
    """A block's numbers in some columns.

    Attributes:
        values: their numbers, a column after another.
        whole: those that float64 would round as integers, by the column's place among them.
        odd: cells that are read one by one: row, place of the column, and text.
        dates: text of other columns.
        lines: the numbers of the rows in the file.
        left_out: the reasons why other lines were left out, with a count each.
        size: bytes.
    """

    values: Sequence[Floats]
    whole: Mapping[int, Raw]
    odd: Sequence[tuple[int, int, bytes]]
    dates: Mapping[int, Raw]
    lines: Sequence[int]
    left_out: Mapping[str, int]
    size: int


Read: TypeAlias = Callable[[bytes], Sequence[Floats] | None]
"""From the lines of a block to its wanted columns; None for lines that are not all rows."""


def reader_of(layout: Layout, dates: list[int], columns: list[int]) -> Read:
    """The reader of the blocks in which each line is a row, and the wanted cells are numbers."""
    if layout.chosen or dates or not columns:
        return _nothing
    delimiter, point = (layout.delimiter or " ").encode(), layout.point.encode()
    form = Form(delimiter, point, len(layout.names), columns)
    read = reader(layout.path.stat().st_size)
    if any(read(head + b"\n", form) is not None for head in layout.heads):
        return _nothing  # a repetition of it is not a row
    return lambda text: read(text, form)


def _nothing(text: bytes) -> None:
    return None


def read_part(
    layout: Layout, block: Block, dates: list[int], columns: list[int], read: Read
) -> Part:
    """Some columns of a block, and those of its dates, by a reader where it can read them."""
    values = read(block.text) if len(block.text) >= _FEW and block.text.endswith(b"\n") else None
    if values is None:
        return _from_cells(layout, block, dates, columns)
    lines = range(block.line, block.line + len(values[0]))
    return Part(values, {}, [], {}, lines, {}, len(block.text))


def _from_cells(layout: Layout, block: Block, dates: list[int], columns: list[int]) -> Part:
    """Any block, cell by cell where necessary."""
    rows = read_rows(layout, block)
    numbers = rows.grid.numbers(columns)
    values = numbers.values.reshape(-1, max(len(columns), 1))
    row, place = np.divmod(numbers.odd, max(len(columns), 1))
    written = rows.grid.chosen(columns, numbers.odd)
    cells = {
        date: np.array([text_of(layout, cell).encode() for cell in rows.grid.cells(date)])
        for date in dates
    }
    return Part(
        [values[:, k] for k in range(len(columns))],
        rows.grid.whole(columns, numbers),
        list(zip(row.tolist(), place.tolist(), written, strict=True)),
        {date: column for date, column in cells.items() if len(column)},
        rows.lines,
        rows.left_out,
        len(block.text),
    )


def mend(
    layout: Layout,
    part: Part,
    columns: list[int],
    known: dict[bytes, tuple[float, str] | None],
    notes: Counter[str],
) -> None:
    """Read the cells that are no plain numbers one by one."""
    for row, place, cell in part.odd:
        if len(known) > _KNOWN:
            known.clear()
        if cell not in known:
            known[cell] = read_cell(text_of(layout, cell), layout.point)
        found, column = known[cell], columns[place]
        if found is None:
            raise _no_number(layout, part.lines[row], column, text_of(layout, cell))
        part.values[place][row] = found[0]
        if found[1]:
            notes[f"{layout.names[column]}: {found[1]}"] += 1


def text_of(layout: Layout, cell: bytes) -> str:
    """A cell as it was written."""
    text = cell.decode(layout.encoding.letters, "replace")
    return text.replace(INSIDE, layout.delimiter or " ")


def _no_number(layout: Layout, line: int, column: int, cell: str) -> LogError:
    way_out = "correct it, remove the line, make it a comment with # or map another column"
    if read_cell(cell, "." if layout.point == "," else ",") is not None:
        way_out = "export the log with decimal points everywhere"
    shown = cell if len(cell) <= _SHOWN else f"{cell[: _SHOWN - 3]}..."
    return LogError(
        f"{layout.path.name}: line {line}, column {layout.names[column]!r} holds {shown!r}, not a "
        f"number; {way_out}"
    )
