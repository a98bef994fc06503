"""MATLAB logs: MAT files of version 5, and of version 7.3 (HDF5, by h5py in a process apart)."""

import struct
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from tuner.data import mat
from tuner.data.logs.contents import Contents, Group, table_of
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw, Table
from tuner.data.mat_objects import Columns, Objects, columns_of
from tuner.limits import check_amount

FORMAT = "MATLAB file of version 5"
_DEEPEST = 8
_DAMAGE = (
    ValueError, KeyError, IndexError, TypeError, OverflowError, MemoryError, OSError, struct.error,
    zlib.error,
)  # fmt: skip


def open_mat5(path: Path) -> Table:
    """Open a MAT file of version 5; the fields of a struct are columns ``struct.field``.

    Row and column vectors come as 1-D arrays, a struct array of single numbers as one column per
    field. The variables of a table are ``table.variable``; those of a timetable have a clock of
    their own, its row times.

    Raises:
        LogError: where the file is damaged or holds no columns.
    """
    try:
        check_amount("the MAT file", path.stat().st_size, "save fewer variables in it")
        variables = mat.read(np.memmap(path, np.uint8, "r").data)  # may be read only in part
        groups, columns, left = _sorted_out(variables)
    except _DAMAGE as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise LogError(
            f"{path.name}: the MAT file is damaged ({reason}); copy or save it again"
        ) from error
    if not columns:
        why = f" but {left[0]}" if left else "; save the log's columns in it"
        raise LogError(f"{path.name}: the MAT file holds no arrays{why}")

    def load(names: Sequence[str]) -> dict[str, Raw]:
        return {name: columns[name] for name in names}

    return table_of(path, Contents(FORMAT, groups, left), load)


_EXPORTS = {
    "timetable": "S = table2struct(timetable2table({0}, 'ConvertRowTimes', false), "
    "'ToScalar', true); S.Time = seconds({0}.Properties.RowTimes - {0}.Properties.RowTimes(1)); ",
    "table": "S = table2struct({0}, 'ToScalar', true); ",
    "timeseries": "S = struct('Time', {0}.Time, 'Data', {0}.Data); ",
    "datetime": "S = struct('Time', posixtime({0})); ",
    "duration": "S = struct('Time', seconds({0})); ",
}
"""The MATLAB lines that make plain columns of an object."""


def not_read(name: str, kind: str) -> str:
    """The note on an object that is not read.

    >>> not_read("d", "duration")
    "'d' is a duration, not read; S = struct('Time', seconds(d)); save('log.mat', '-struct', 'S')"
    """
    if kind not in _EXPORTS:
        return f"{name!r} is of the class {kind!r}, not read; save its numbers as plain arrays"
    lines = _EXPORTS[kind].format(name)
    return f"{name!r} is a {kind}, not read; {lines}save('log.mat', '-struct', 'S')"


def _sorted_out(
    variables: dict[str, mat.Value],
) -> tuple[list[Group], dict[str, Raw], list[str]]:
    """The groups of a file, its columns, and notes on what is left out."""
    columns: dict[str, Raw] = {}
    units: dict[str, str] = {}
    left: list[str] = []
    groups: list[Group] = []
    subsystem = variables.get("")
    for name, value in _flat(variables, "", _DEEPEST):
        if not isinstance(value, mat.Opaque):
            columns[name] = value
            continue
        found = _read(subsystem, value)
        if found is None:
            left.append(not_read(name, value.kind))
            continue
        left += [f"{name}.{column!s} is not a number, and left out" for column in found.left]
        own = {f"{name}.{key}" if key else name: _squeezed(a) for key, a in found.columns.items()}
        columns |= own
        if found.time is None:
            units |= {f"{name}.{key}" if key else name: u for key, u in found.units.items()}
        else:
            groups.append(_timetable(name, found, own))
    timed = {group.prefix + column for group in groups for column in group.columns}
    plain = {name: _width(array) for name, array in columns.items() if name not in timed}
    if plain:
        groups.insert(0, Group("", plain, units=units))
    return groups, columns, left


def _read(subsystem: mat.Value, value: mat.Opaque) -> Columns | None:
    """The columns of an object; None where it has none, or an unknown form."""
    if not isinstance(subsystem, np.ndarray):
        return None
    try:
        return columns_of(Objects.of(subsystem), value)
    except _DAMAGE:
        return None


def _timetable(name: str, found: Columns, own: dict[str, Raw]) -> Group:
    prefix, time = f"{name}.", found.time
    assert time is not None
    rows = len(own[prefix + time])
    widths = {column: _width(own[prefix + column]) for column in found.columns}
    return Group(prefix, widths, rows, time, found.units[time], found.units)


def _flat(
    variables: dict[str, mat.Value], prefix: str, deep: int
) -> Iterator[tuple[str, "Raw | mat.Opaque"]]:
    """The arrays by name; those in structs have the struct's name as prefix."""
    for name, value in variables.items():
        full = prefix + name
        if not name:
            continue
        if isinstance(value, mat.Structs) and deep:
            yield from _flat(_fields(value), f"{full}.", deep - 1)
        elif isinstance(value, np.ndarray):
            yield full, _squeezed(value)
        elif isinstance(value, str):
            yield full, np.asarray(value)
        elif isinstance(value, mat.Opaque):
            yield full, value


def _fields(value: mat.Structs) -> dict[str, mat.Value]:
    """The fields of a struct; of a struct array those of single numbers, as columns."""
    if len(next(iter(value.fields.values()), [])) == 1:
        return {name: values[0] for name, values in value.fields.items()}
    return {
        name: np.array([value.item() for value in values if isinstance(value, np.ndarray)])
        for name, values in value.fields.items()
        if all(isinstance(value, np.ndarray) and value.size == 1 for value in values)
    }


def _squeezed(array: Raw) -> Raw:
    return np.squeeze(array) if array.size else np.empty(0)


def _width(array: Raw) -> int:
    return int(array.shape[1]) if array.ndim == 2 else 0
