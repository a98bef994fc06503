"""From raw columns to channels: one checked float64 array per mapping."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.error import LogError, suggest
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.passes import BLOCK, in_parts
from tuner.data.logs.table import Floats, Loaded, Raw, Table
from tuner.names import counted

_EXACT = 1 << 53
HUGE = 1e150
"""Numbers from here on mean that nothing was measured."""
_NOT_REAL = {
    "c": "is complex; map an array of its real parts",
    "O": "holds Python objects; save plain numbers",
    "U": "holds text; map a column of numbers",
    "S": "holds text; map a column of numbers",
    "V": "is structured; save its fields as arrays of their own",
    "M": "holds dates; save seconds as numbers",
    "m": "holds time differences; save seconds as numbers",
}


@dataclass(frozen=True)
class Columns:
    """A table and those of its columns that are needed.

    Attributes:
        table: where they come from.
        raw: the arrays by name, with samples along the first axis; scalars of size 1.
    """

    table: Table
    raw: dict[str, Raw]

    def error(self, mapping: Mapping, rest: str) -> LogError:
        """A sentence about one mapping."""
        return LogError(
            f"{self.table.file}: column {mapping.source!r} (mapped to {mapping.channel}) {rest}"
        )

    def rows(self, rows: NDArray[np.intp], samples: int) -> "Columns":
        """Some rows of the columns that have so many samples; the others stay."""
        raw = {
            name: array[rows] if array.ndim and len(array) == samples else array
            for name, array in self.raw.items()
        }
        place = self.table.place
        table = replace(self.table, place=lambda row: place(int(rows[row])))
        return Columns(table, raw)

    def with_notes(self, notes: Iterable[str]) -> "Columns":
        """The columns with further notes."""
        return replace(self, table=replace(self.table, notes=(*self.table.notes, *notes)))


def load_columns(table: Table, mappings: Iterable[Mapping], extra: Iterable[str]) -> Columns:
    """Load what the mappings, resolved by the table, need, and the extra names.

    Raises:
        LogError: where the columns cannot be read.
    """
    names = dict.fromkeys(extra)
    for mapping in mappings:
        names[mapping.column] = None
        if isinstance(mapping.factor, str) and mapping.factor in table.names:
            names[mapping.factor] = None
    loaded = Loaded.of(table.load(tuple(names)))
    return Columns(table, loaded.raw).with_notes(loaded.notes)


def pick(columns: Columns, mapping: Mapping) -> Raw:
    """The raw column of a mapping, ``(N,)``, of real numbers.

    Raises:
        LogError: where it is something else, or the index does not fit.
    """
    array = pick_whole(columns, mapping)
    if array.ndim == 1:
        return array
    name, width = mapping.column, array.shape[1]
    raise columns.error(mapping, f"has shape {array.shape}; write {name}[0] to {name}[{width - 1}]")


def pick_whole(columns: Columns, mapping: Mapping) -> Raw:
    """The raw column of a mapping, ``(N,)``, or all columns of a 2-D array, ``(N, k)``.

    Raises:
        LogError: where it does not hold real numbers, or the index does not fit.
    """
    array = columns.raw[mapping.column]
    if array.dtype.kind in _NOT_REAL:
        raise columns.error(mapping, _NOT_REAL[array.dtype.kind])
    if array.ndim == 0:
        raise columns.error(mapping, "is a single number; map a column of samples")
    if array.ndim > 2:
        raise columns.error(mapping, f"is {array.ndim}-dimensional; save one column per channel")
    if array.ndim == 1:
        if mapping.index is not None:
            raise columns.error(mapping, "is one-dimensional; leave the index out")
        return array
    return _of_two(columns, mapping, array)


def _of_two(columns: Columns, mapping: Mapping, array: Raw) -> Raw:
    """The column of a 2-D array that the index chooses."""
    rows, width = array.shape
    if rows < width:
        raise columns.error(
            mapping, f"has shape {array.shape}, so its samples lie in rows; save it transposed"
        )
    if mapping.index is None:
        return array[:, 0] if width == 1 else array
    if mapping.index >= width:
        name = mapping.column
        raise columns.error(
            mapping, f"has shape {array.shape}; write {name}[0] to {name}[{width - 1}]"
        )
    return array[:, mapping.index]


def rounded(column: Raw) -> str:
    """A note on numbers of less than 64 bits; empty for none.

    >>> rounded(np.zeros(3, np.float32)), rounded(np.zeros(3))
    ('float32, widened to float64; what was rounded away stays lost', '')
    """
    if column.dtype.kind != "f" or column.dtype.itemsize >= 8:
        return ""
    return f"{column.dtype.name}, widened to float64; what was rounded away stays lost"


def factor_of(columns: Columns, mapping: Mapping) -> float:
    """The factor of a mapping; 1 where it has none.

    Raises:
        LogError: where it names no scalar of the file.
    """
    if mapping.factor is None:
        return 1.0
    if isinstance(mapping.factor, float):
        return mapping.factor
    return scalar(columns, mapping.factor)


def scalar(columns: Columns, name: str) -> float:
    """A number that stands alone in the file.

    Raises:
        LogError: where there is none of that name, or it is 0 or not finite.
    """
    file, array = columns.table.file, columns.raw.get(name)
    if array is None or array.size != 1 or array.dtype.kind not in "biuf":
        known = suggest(name, columns.table.names)
        raise LogError(f"{file}: {name!r} is neither a number nor a scalar of the file; {known}")
    value = float(array.item())
    if not np.isfinite(value) or value == 0.0:
        raise LogError(f"{file}: the scalar {name!r} is {value:g}; give the number yourself")
    return value


def to_float(columns: Columns, mapping: Mapping, column: Raw) -> Floats:
    """The column times its factor as float64, contiguous; NaN where nothing was measured.

    NaN, Inf and the huge numbers of some loggers count as missing.

    Raises:
        LogError: for integers that float64 cannot hold, and where the factor is unusable.
    """
    _check_exact(columns, mapping, column)
    factor = factor_of(columns, mapping) * (-1.0 if mapping.minus else 1.0)
    if factor == 1.0 and column.dtype == np.float64 and column.flags.c_contiguous:
        values: Floats = column
        measured = _all_measured(values)
    else:
        values = np.empty(column.shape)
        measured = _scaled(column, factor, values)
    return values if measured else _without_missing(values)


def _scaled(column: Raw, factor: float, values: Floats) -> bool:
    """Write a column times a factor, and tell whether nothing is missing."""

    def part(starts: range) -> bool:
        measured = True
        with np.errstate(over="ignore"):
            for at in starts:
                block = values[at : at + BLOCK]
                block[...] = column[at : at + BLOCK]
                if factor != 1.0:
                    block *= factor
                measured = measured and _is_measured(block)
        return measured

    return column.size > 0 and all(in_parts(part, len(column)))


def _all_measured(values: Floats) -> bool:
    """Whether there are numbers and none of them is missing."""

    def part(starts: range) -> bool:
        return all(_is_measured(values[at : at + BLOCK]) for at in starts)

    return values.size > 0 and all(in_parts(part, len(values)))


def _without_missing(values: Floats) -> Floats:
    """A copy with NaN for what was not measured."""
    found = np.full(values.shape, np.nan)

    def part(starts: range) -> None:
        for at in starts:
            block = values[at : at + BLOCK]
            np.copyto(found[at : at + BLOCK], block, where=np.abs(block) < HUGE)

    in_parts(part, len(values))
    return found


def _is_measured(block: Floats) -> bool:
    return bool(block.min() > -HUGE and block.max() < HUGE)  # NaN compares false


def _check_exact(columns: Columns, mapping: Mapping, column: Raw) -> None:
    def part(starts: range) -> bool:
        blocks = (column[at : at + BLOCK] for at in starts)
        return all(block.max() <= _EXACT and block.min() >= -_EXACT for block in blocks)

    wide = column.dtype.kind in "iu" and column.dtype.itemsize == 8 and column.size > 0
    if wide and not all(in_parts(part, len(column))):
        raise columns.error(
            mapping, "holds integers beyond 2**53, which float64 rounds; subtract an offset first"
        )


def check_finite(columns: Columns, mapping: Mapping, values: Raw) -> None:
    """Refuse NaN, Inf and the huge numbers that some loggers write instead.

    Raises:
        LogError: with the first row and the number of rows.
    """
    numbers = np.asarray(values, float)
    if not numbers.size or _all_measured(numbers):
        return
    missing = ~(np.abs(numbers) < HUGE)  # NaN compares false
    rows = counted(int(missing.sum()), "row")
    place = columns.table.place(int(missing.argmax()))
    raise columns.error(
        mapping,
        f"is missing (empty, NaN, Inf or beyond 1e150) in {rows}, first at {place}; "
        "cut them out or interpolate first",
    )
