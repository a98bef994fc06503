"""Parquet and Feather (Arrow IPC), by pyarrow; fields of a struct are ``struct.field``."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tuner.data.logs.contents import Contents, Group
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw
from tuner.limits import check_amount, size_text, unpacked

_PARQUET = b"PAR1"
_DEEPEST = 8
_MOST = 10_000


def contents(path: Path) -> Contents:
    """The columns of numbers, times and texts.

    Raises:
        LogError: where there are none.
    """
    kind, schema, rows = _schema(path)
    fields = {name: field for name, field in _flat(schema, "", _DEEPEST) if _is_column(field)}
    if not fields:
        raise LogError(f"the {kind} file holds no columns of numbers; save them as columns")
    columns = {name: _width(field) for name, field in fields.items()}
    units = {name: unit for name, field in fields.items() if (unit := _unit(field))}
    dated = [name for name, field in fields.items() if _is_stamp(field)]
    time = dated[0] if len(dated) == 1 else None
    notes = (f"the time is {time!r}, a column of time stamps in {units[time]}",) if time else ()
    unit_of_time = units[time] if time else None
    return Contents(kind, [Group("", columns, rows, time, unit_of_time, units)], notes)


def load(path: Path, names: Sequence[str]) -> dict[str, Raw]:
    """Columns by their names; what is missing is NaN, times are integers."""
    from pyarrow import parquet

    _, _, rows = _schema(path)
    size = 8 * rows * len(names)
    if size > unpacked(path.stat().st_size):
        raise LogError(
            f"{names[0]!r} and others would unpack to {size_text(size)}, which no log does; save "
            "fewer rows"
        )
    check_amount("what is mapped of it", size, "map less or cut it into parts")
    if _is_parquet(path):
        file = parquet.ParquetFile(path)
        table = file.read([top for top in file.schema_arrow.names if _holds(top, names)])
    else:
        table = _feather(
            path, [top for top in _feather(path, None).schema.names if _holds(top, names)]
        )
    for _ in range(_DEEPEST):
        table = table.flatten()
    return {name: _column(table.column(name)) for name in names}


def _schema(path: Path) -> tuple[str, Any, int]:
    """The kind of file, its fields and how many rows it has."""
    from pyarrow import parquet

    if not _is_parquet(path):
        table = _feather(path, None)
        return "Feather file", table.schema, table.num_rows
    file = parquet.ParquetFile(path)
    return "Parquet file", file.schema_arrow, file.metadata.num_rows


def _is_parquet(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(len(_PARQUET)) == _PARQUET


def _feather(path: Path, columns: Sequence[str] | None) -> Any:
    from pyarrow import feather

    return feather.read_table(path, columns, memory_map=True)


def _holds(top: str, names: Sequence[str]) -> bool:
    return any(name == top or name.startswith(f"{top}.") for name in names)


def _flat(fields: Any, prefix: str, deep: int) -> Iterator[tuple[str, Any]]:
    """The types of all columns by name, those of structs with dots."""
    from pyarrow import types

    for field in fields:
        name = prefix + field.name
        if types.is_struct(field.type) and deep:
            yield from _flat(field.type, f"{name}.", deep - 1)
        else:
            yield name, field.type


def _is_column(kind: Any) -> bool:
    from pyarrow import types

    if types.is_fixed_size_list(kind):
        kind = kind.value_type
        return bool(types.is_floating(kind) or types.is_integer(kind))
    tests = (
        types.is_floating,
        types.is_integer,
        types.is_boolean,
        types.is_timestamp,
        types.is_duration,
        types.is_string,
        types.is_large_string,
        types.is_decimal,
    )
    return any(test(kind) for test in tests)


def _is_stamp(kind: Any) -> bool:
    from pyarrow import types

    return bool(types.is_timestamp(kind))


def _width(kind: Any) -> int:
    from pyarrow import types

    return int(kind.list_size) if types.is_fixed_size_list(kind) else 0


def _unit(kind: Any) -> str:
    """The unit of a time stamp or a duration; ``""`` of anything else."""
    from pyarrow import types

    return str(kind.unit) if types.is_timestamp(kind) or types.is_duration(kind) else ""


def _column(column: Any) -> Raw:
    import pyarrow
    from pyarrow import types

    kind = column.type
    if types.is_timestamp(kind) or types.is_duration(kind):
        column = column.cast(pyarrow.int64())
    if types.is_decimal(kind):
        column = column.cast(pyarrow.float64())
    if types.is_string(kind) or types.is_large_string(kind):
        return np.array([text or "" for text in column.to_pylist()])
    if types.is_fixed_size_list(kind):
        flat = column.combine_chunks().flatten()
        return np.asarray(flat.to_numpy(zero_copy_only=False)).reshape(-1, kind.list_size)
    if types.is_boolean(kind):
        column = column.cast(pyarrow.uint8())
    return np.asarray(column.to_numpy())
