"""When the samples were taken: from a time column, a given rate or a scalar of the file."""

from collections.abc import Iterable
from dataclasses import replace

from tuner.data.logs.clock import Clock, read_clock
from tuner.data.logs.error import LogError, counted, suggest
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.table import Table
from tuner.data.logs.timename import is_time
from tuner.data.logs.values import Columns, pick, scalar

_RATES = ("fs", "rate", "rate_hz", "sampling_rate", "sample_rate")
_CONTRADICTION = 0.01


def timing_names(table: Table) -> list[str]:
    """The names in a file that may tell the timing: time columns and scalar rates."""
    return [*_time_names(table), *_rate_names(table)]


def find_clock(
    columns: Columns, time: Mapping | None, rate_hz: float | None, samples: int
) -> Clock:
    """When the samples of a file were taken.

    Args:
        columns: the loaded columns, among them those of :func:`timing_names`.
        time: the time column where the user named one; otherwise it is found by its name.
        rate_hz: the rate where the user gave one.
        samples: how many samples the file holds.

    Raises:
        LogError: where neither time nor rate is known, they contradict each other, or the
            time column is unusable.
    """
    mapping = time or _found(columns, samples)
    if mapping is not None:
        return _from_time(columns, mapping, rate_hz, samples)
    if rate_hz is not None:
        return Clock.rated(samples, rate_hz, "--rate")
    name, rate = _scalar_rate(columns)
    return Clock.rated(samples, rate, f"scalar {name!r}")


def _time_names(table: Table) -> Iterable[str]:
    if table.time is not None:
        return (table.time.column,)
    return (
        name
        for name in table.names
        if is_time(name.removeprefix(table.prefix)) and name not in table.texts
    )


def _rate_names(table: Table) -> Iterable[str]:
    if table.numbered:
        return ()  # a text file has columns only
    return (name for name in table.names if name.rsplit(".", 1)[-1].lower() in _RATES)


def _found(columns: Columns, samples: int) -> Mapping | None:
    """The first column that is time by its name and could be: numbers, one per sample."""
    for name in _time_names(columns.table):
        array = columns.raw[name]
        if array.ndim > 0 and array.size == len(array) == samples and array.dtype.kind in "iuf":
            return columns.table.time or Mapping("time", name)
    return None


def _from_time(columns: Columns, time: Mapping, rate_hz: float | None, samples: int) -> Clock:
    column = pick(columns, time)
    if len(column) != samples:
        rows = counted(len(column), "row")
        raise columns.error(
            time, f"has {rows} where the channels have {samples}; name another --time"
        )
    if rate_hz is None:
        return read_clock(columns, time, column)
    if repeated := int((column[1:] == column[:-1]).sum()):
        told = f"time {time.column!r}: left out for its {counted(repeated, 'repeated time')}"
        return Clock.rated(samples, rate_hz, "--rate", (told,))
    clock = read_clock(columns, time, column)
    if abs(rate_hz - clock.rate_hz) > _CONTRADICTION * clock.rate_hz:
        raise columns.error(
            time,
            f"runs at {clock.rate_hz:.6g} Hz, which contradicts --rate {rate_hz:.6g} Hz; leave "
            f"--rate out or name the unit of time, such as --time '{time.column}:ms'",
        )
    source = f"{clock.source} and --rate"
    return replace(clock, step=1.0 / rate_hz, rate_hz=float(rate_hz), source=source)


def _scalar_rate(columns: Columns) -> tuple[str, float]:
    """The rate that the file itself tells."""
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
