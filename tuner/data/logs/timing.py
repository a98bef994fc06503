"""The times of samples, from time columns, a given rate or a scalar of the file."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.clock import Clock, read_clock
from tuner.data.logs.date_columns import date_and_time
from tuner.data.logs.error import LogError, quoted, suggest
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.table import Table
from tuner.data.logs.ticks import read_times, same_as_before
from tuner.data.logs.timename import fraction_of, is_time
from tuner.data.logs.values import Columns, pick, scalar
from tuner.names import counted

RESTART = "restart"
"""The word of --by for recordings that begin where the time runs back."""

_RATES = ("fs", "rate", "rate_hz", "sampling_rate", "sample_rate")
_AGREES = 0.01


def timing_names(table: Table) -> list[str]:
    """The names in a file that may give the timing: time columns and scalar rates."""
    times = _time_names(table)
    fractions = [fraction_of(name, table.names) for name in times]
    return [*times, *(name for name in fractions if name), *_rate_names(table)]


def find_clock(
    columns: Columns, time: Sequence[Mapping] | None, rate_hz: float | None, samples: int
) -> Clock:
    """The clock of a file's samples.

    Args:
        columns: the loaded columns, among them those of :func:`timing_names`.
        time: the time columns where the user named them; otherwise they are found by their names.
        rate_hz: the rate where the user gave one; it overrules a time column that differs.
        samples: number of samples in the file.

    Raises:
        LogError: where neither time nor rate is known, or the time column is unusable.
    """
    parts = time_parts(columns, time, samples)
    if parts is None and rate_hz is None:
        name, rate = _scalar_rate(columns)
        return Clock.rated(samples, rate, f"scalar {name!r}")
    if parts is None:
        return Clock.rated(samples, rate_hz or 0.0, "--rate")
    return _rated(columns, parts, rate_hz, samples) if rate_hz else read_clock(columns, parts)


def time_parts(
    columns: Columns, time: Sequence[Mapping] | None, samples: int
) -> tuple[Mapping, ...] | None:
    """The columns whose sum is the time: those named, or those found; None without any.

    Raises:
        LogError: where those named have another number of samples.
    """
    if time is None:
        return _found(columns, samples)
    for part in time:
        column = columns.raw[part.column]
        column = column if column.dtype.kind == "S" else pick(columns, part)
        if len(column) != samples:
            rows = counted(len(column), "row")
            raise columns.error(
                part, f"has {rows} where the channels have {samples}; name another --time"
            )
    return tuple(time)


def without_repeats(columns: Columns, time: Sequence[Mapping] | None, samples: int) -> Columns:
    """The columns without the rows that have the time of the previous row.

    Raises:
        LogError: where no column holds the time.
    """
    parts = time_parts(columns, time, samples)
    if parts is None:
        raise LogError(
            f"{columns.table.file}: --drop-repeats needs a time column; give --time COLUMN"
        )
    new = ~same_as_before(columns, parts)
    if new.all():
        return columns.with_notes(["0 rows with the time of the row before left out"])
    note = f"{counted(int((~new).sum()), 'row')} with the time of the row before left out"
    if others := _unlike(columns, np.flatnonzero(~new), samples):
        note += f", {others} of them with other numbers"
    return columns.rows(np.flatnonzero(new), samples).with_notes([note])


def _unlike(columns: Columns, rows: NDArray[np.intp], samples: int) -> int:
    """Number of the given rows that differ in a column from the previous row."""
    differ = np.zeros(len(rows), bool)
    for array in columns.raw.values():
        if array.ndim and len(array) == samples:
            here, before = (array[k].reshape(len(rows), -1) for k in (rows, rows - 1))
            unlike = here != before
            if array.dtype.kind == "f":
                unlike &= ~(np.isnan(here) & np.isnan(before))
            differ |= unlike.any(axis=1)
    return int(differ.sum())


def restarts(columns: Columns, time: Sequence[Mapping] | None, samples: int) -> NDArray[np.int64]:
    """The number of each row's recording, from 1: a new one begins where time runs back.

    Raises:
        LogError: where no column holds the time.
    """
    parts = time_parts(columns, time, samples)
    if parts is None:
        raise LogError(
            f"{columns.table.file}: --by {RESTART} needs a time column; give --time COLUMN"
        )
    seconds = read_times(columns, parts).steps.seconds
    return 1 + np.cumsum(np.diff(seconds, prepend=seconds[0]) < 0)


def _time_names(table: Table) -> list[str]:
    """Columns of numbers that are time by their names, then dates and times of day."""
    if table.time is not None:
        return [table.time.column]
    known = table.texts | table.moments
    numbers = (name for name in table.names if name not in known)
    named = [name for name in numbers if is_time(name.removeprefix(table.prefix))]
    return [*named, *(name for name in table.names if name in table.moments)]


def _rate_names(table: Table) -> Iterable[str]:
    if table.numbered:
        return ()  # a text file has columns only
    return (name for name in table.names if name.rsplit(".", 1)[-1].lower() in _RATES)


def _found(columns: Columns, samples: int) -> tuple[Mapping, ...] | None:
    """The first usable time column, one number per sample, and its companions."""
    table = columns.table
    for name in _time_names(table):
        array = columns.raw[name]
        if array.ndim == 0 or not array.size == len(array) == samples:
            continue
        if array.dtype.kind == "S":
            return tuple(Mapping("time", part) for part in date_and_time(columns, name))
        fraction = fraction_of(name, table.names)
        if array.dtype.kind in "iuf" and fraction is None:
            return (table.time or Mapping("time", name),)
        if array.dtype.kind in "iuf":
            small = "us" if "us" in (fraction or "").lower() else "ns"
            return (Mapping("time", name, unit="s"), Mapping("time", fraction or "", unit=small))
    return None


def _rated(columns: Columns, parts: Sequence[Mapping], rate_hz: float, samples: int) -> Clock:
    """The clock of a rate, with the times and gaps of the time column where they agree."""
    names = quoted(part.column for part in parts)
    try:
        repeated = int(np.count_nonzero(same_as_before(columns, parts)))
        clock = read_clock(columns, parts)
    except LogError as error:
        why = str(error).partition(" (mapped to time) ")[2].partition(";")[0]
        return _overruled(samples, rate_hz, names, f"it {why}")
    if repeated:
        return _overruled(samples, rate_hz, names, f"it has {counted(repeated, 'repeated time')}")
    if abs(rate_hz - clock.rate_hz) > _AGREES * clock.rate_hz:
        why = f"it runs at {clock.rate_hz:.6g} Hz as it stands, {rate_hz / clock.rate_hz:.4g} times"
        return _overruled(samples, rate_hz, names, f"{why} as many in --rate")
    source = f"{clock.source} and --rate"
    return replace(clock, step=1.0 / rate_hz, rate_hz=float(rate_hz), source=source)


def _overruled(samples: int, rate_hz: float, names: str, why: str) -> Clock:
    note = f"time {names}: overruled by --rate {rate_hz:g}, though {why}"
    return Clock.rated(samples, rate_hz, "--rate", (note,))


def _scalar_rate(columns: Columns) -> tuple[str, float]:
    """The rate that the file itself gives."""
    file, names = columns.table.file, columns.table.names
    found = [name for name in _rate_names(columns.table) if columns.raw[name].size == 1]
    if not found:
        raise LogError(
            f"{file}: neither a time column nor a rate is known; "
            f"give --rate HZ or --time COLUMN ({suggest('time', names)})"
        )
    rate = scalar(columns, found[0])
    if rate < 0:
        raise LogError(f"{file}: the scalar {found[0]!r} is {rate:g}; give --rate HZ")
    return found[0], rate
