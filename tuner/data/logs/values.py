"""From raw columns to channels: one checked 1-D float64 array per mapping."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from tuner.data.logs.error import LogError, counted, suggest
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.table import Floats, Raw, Table

_EXACT = 1 << 53
_HUGE = 1e150
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
    return Columns(table, table.load(tuple(names)))


def pick(columns: Columns, mapping: Mapping) -> Raw:
    """The raw column of a mapping, ``(N,)``, of real numbers that are not rounded.

    Raises:
        LogError: where it is something else, or the index does not fit.
    """
    array = columns.raw[mapping.column]
    kind = array.dtype.kind
    if kind in _NOT_REAL:
        raise columns.error(mapping, _NOT_REAL[kind])
    if kind == "f" and array.dtype.itemsize < 8:
        raise columns.error(
            mapping,
            f"is {array.dtype.name}; a filter tuned on rounded data learns the rounding, so save "
            "the original as float64 (np.asarray(x, float))",
        )
    return _one_column(columns, mapping, array)


def _one_column(columns: Columns, mapping: Mapping, array: Raw) -> Raw:
    """The column that the index chooses."""
    if array.ndim == 0:
        raise columns.error(mapping, "is a single number; map a column of samples")
    if array.ndim > 2:
        raise columns.error(mapping, f"is {array.ndim}-dimensional; save one column per channel")
    if array.ndim == 1:
        if mapping.index is not None:
            raise columns.error(mapping, "is one-dimensional; leave the index out")
        return array
    rows, width = array.shape
    if rows < width:
        raise columns.error(
            mapping, f"has shape {array.shape}, so its samples lie in rows; save it transposed"
        )
    index = 0 if mapping.index is None and width == 1 else mapping.index
    if index is None or index >= width:
        name = mapping.column
        raise columns.error(
            mapping, f"has shape {array.shape}; write {name}[0] to {name}[{width - 1}]"
        )
    return array[:, index]


def factor_of(columns: Columns, mapping: Mapping) -> float:
    """What a mapping multiplies by; 1 where it says nothing.

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
    """The column times its factor as float64, contiguous and finite.

    Raises:
        LogError: for missing values, for integers that float64 cannot hold, and where the
            factor is unusable.
    """
    _check_exact(columns, mapping, column)
    with np.errstate(over="ignore"):
        values = np.array(column, dtype=np.float64) * factor_of(columns, mapping)
    check_finite(columns, mapping, values)
    return values


def _check_exact(columns: Columns, mapping: Mapping, column: Raw) -> None:
    wide = column.dtype.kind in "iu" and column.dtype.itemsize == 8 and column.size > 0
    if wide and (column.max() > _EXACT or column.min() < -_EXACT):
        raise columns.error(
            mapping, "holds integers beyond 2**53, which float64 rounds; subtract an offset first"
        )


def check_finite(columns: Columns, mapping: Mapping, values: Raw) -> None:
    """Refuse NaN, Inf and the huge numbers that some loggers write in their place.

    Raises:
        LogError: with the first row and the number of rows.
    """
    missing = ~(np.abs(values) < _HUGE)  # NaN compares false
    if not missing.any():
        return
    rows = counted(int(missing.sum()), "row")
    place = columns.table.place(int(missing.argmax()))
    raise columns.error(
        mapping,
        f"is missing (empty, NaN, Inf or beyond 1e150) in {rows}, first at {place}; "
        "cut them out or interpolate first",
    )
