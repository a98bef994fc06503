"""Blocks of a text log as columns of numbers."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from tuner.data.logs.block import INSIDE, Rows
from tuner.data.logs.cells import read_cell
from tuner.data.logs.decimals import Numbers
from tuner.data.logs.error import LogError
from tuner.data.logs.layout import Layout
from tuner.data.logs.table import Raw

_KNOWN = 10_000
_SHOWN = 40
_LARGE = np.uint64(1 << 53)
_TOP = np.uint64(1 << 63)


@dataclass(frozen=True, eq=False)
class Part:
    """One block: its rows, and some columns of them as numbers, row by row."""

    rows: Rows
    numbers: Numbers


def mend(
    layout: Layout,
    part: Part,
    columns: list[int],
    known: dict[bytes, tuple[float, str] | None],
    told: Counter[str],
) -> None:
    """Read the cells that are no plain numbers one by one."""
    for index in part.numbers.odd.tolist():
        row, column = index // len(columns), columns[index % len(columns)]
        cell = part.rows.grid.cell(row, column)
        if len(known) > _KNOWN:
            known.clear()
        if cell not in known:
            known[cell] = read_cell(text_of(layout, cell), layout.point)
        found = known[cell]
        if found is None:
            raise _no_number(layout, part.rows.lines[row], column, text_of(layout, cell))
        part.numbers.values[index] = found[0]
        if found[1]:
            told[f"{layout.names[column]}: {found[1]}"] += 1


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


def columns_of(part: Part, columns: list[int]) -> list[Raw]:
    """The numbers by column; whole ones that float64 would round as integers."""
    shape = (-1, len(columns))
    values = part.numbers.values.reshape(shape)
    found: list[Raw] = [values[:, k].copy() for k in range(len(columns))]
    whole = part.numbers.whole.reshape(shape)
    for k in np.flatnonzero((whole > _LARGE).any(axis=0)).tolist():
        spans = part.rows.grid.spans
        plain = spans.points[:, columns[k]] == spans.ends[:, columns[k]]
        if plain.all() and whole[:, k].max() < _TOP and np.isfinite(found[k]).all():
            sign = 1 - 2 * part.numbers.negative.reshape(shape)[:, k].astype(np.int64)
            found[k] = sign * whole[:, k].astype(np.int64)
    return found


def joined(parts: list[Raw]) -> Raw:
    """A column from its parts: integers where all of it are whole numbers."""
    if not parts:
        return np.empty(0)
    whole = [part.dtype.kind == "i" for part in parts]
    if any(whole) and not all(whole):
        exact = all(
            is_int or (part == np.trunc(part)).all()
            for is_int, part in zip(whole, parts, strict=True)
        )
        parts = [part.astype(np.int64 if exact else np.float64) for part in parts]
    return np.concatenate(parts)
