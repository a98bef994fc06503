"""Time columns as seconds: numbers in any unit, dates, times of day, and sums of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from tuner.data.logs.epoch import since_1970
from tuner.data.logs.error import counted
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.moments import ORDERS, SHORT, Moments, Ticks, read_moments
from tuner.data.logs.table import Floats, Raw
from tuner.data.logs.timename import UNITS, unit_of
from tuner.data.logs.values import Columns, check_finite, factor_of, pick

_DIGITS = 9
_DAY = 86_400
_NS = Fraction(1, 10**9)
_JUMP = 20.0  # of a usual step: what may be lost where a counter begins anew
_COUNTERS = {
    2.0**16: "2^16",
    2.0**24: "2^24",
    2.0**32: "2^32",
    2.0**32 * 1e-3: "2^32 thousandths",
    2.0**32 * 1e-6: "2^32 millionths",
    86400.0: "a day",
    86400e3: "a day",
    604800.0: "a week",
    604800e3: "a week",
}


@dataclass(frozen=True, eq=False)
class Times:
    """When samples were taken, before it is judged.

    Attributes:
        seconds: since the first, ``(N,)``.
        first: the first as the columns have it, s.
        resolution: the step of the digits they were written with, s.
        known: whether anything tells the unit.
        notes: what was taken for granted.
    """

    seconds: Floats
    first: Fraction
    resolution: float
    known: bool
    notes: tuple[str, ...]


def read_times(columns: Columns, parts: Sequence[Mapping]) -> Times:
    """The sum of time columns, one as a rule.

    Raises:
        LogError: where one has missing values, no unit of time, or more than one meaning.
    """
    column = columns.raw[parts[0].column]
    if len(parts) == 1 and column.dtype.kind not in "SUMm":
        return _counted(columns, parts[0], pick(columns, parts[0]))
    found = [_nanoseconds(columns, part) for part in parts]
    ticks, notes = sum(one[0] for one in found), [note for one in found for note in one[2]]
    if all(one[3] for one in found):
        ticks, past = _past_midnight(ticks)
        notes += [f"midnight passed {counted(past, 'time')}"] if past else []
    resolution = min(one[1] for one in found)
    seconds = (ticks - ticks[0]).astype(np.float64) * 1e-9
    return Times(seconds, int(ticks[0]) * _NS, 1e-9 * resolution, True, tuple(notes))


def repeats(columns: Columns, parts: Sequence[Mapping]) -> "np.ndarray":
    """Which rows have the time of the row before, ``(N,)``."""
    same = [
        np.append(False, column[1:] == column[:-1])
        for column in (columns.raw[part.column] for part in parts)
    ]
    return np.logical_and.reduce(same)


def _counted(columns: Columns, mapping: Mapping, column: Raw) -> Times:
    """Numbers in a unit of time."""
    check_finite(columns, mapping, column)
    scale, known, note = _scale(columns, mapping, column)
    column, turned = _unwrapped(column)
    first = Fraction(column[0].item()) * scale
    seconds, resolution = _seconds(column, float(scale))
    return Times(seconds, first, resolution, known, tuple(filter(None, (note, turned))))


def _scale(columns: Columns, mapping: Mapping, column: Raw) -> tuple[Fraction, bool, str]:
    """Seconds per unit of the column, whether anything named the unit, and what was assumed."""
    if mapping.unit is not None and mapping.unit.lower() not in UNITS:
        raise columns.error(
            mapping, f"is in {mapping.unit!r}, no unit of time; use s, ms, us or ns"
        )
    if mapping.unit is not None or mapping.factor is not None:
        factor = Fraction(factor_of(columns, mapping))
        return _exact(mapping.unit or "s") * factor, True, ""
    written = columns.table.units.get(mapping.column, "").lower()
    unit = unit_of(mapping.column) or (written if written in UNITS else None)
    if unit is None and (found := since_1970(column)):
        return _exact(found), True, f"taken as {found} since 1970"
    return _exact(unit or "s"), unit is not None, ""


def _exact(unit: str) -> Fraction:
    """Seconds per unit of time, without rounding: 1e-9 is no double."""
    return Fraction(str(UNITS[unit.lower()]))


def _seconds(column: Raw, scale: float) -> tuple[Floats, float]:
    """Seconds since the first sample, and the step of the digits they were written with.

    Integers are subtracted as integers: nanoseconds since 1970 do not fit into float64.
    """
    if column.dtype.kind in "iub":
        column, digits = column.astype(np.int64), 1.0
    else:
        single = column.dtype.itemsize < 8
        coarse = float(np.spacing(np.abs(column).max())) if single else 0.0
        column = column.astype(np.float64)
        digits = max(_digits(column), coarse)
    seconds = (column - column[0]).astype(np.float64) * scale
    return seconds, digits * abs(scale)


def _digits(column: Floats) -> float:
    """The step of the last decimal digit in use, 10**-k; rounding alone where there are more."""
    sample = column[:: max(1, len(column) // 1000)]
    noise = 4.0 * float(np.spacing(np.abs(column).max()))
    for decimals in range(_DIGITS + 1):
        if np.abs(sample - np.round(sample, decimals)).max() <= noise:
            return max(10.0**-decimals, noise)
    return noise


def _unwrapped(column: Raw) -> tuple[Raw, str]:
    """A counter that began anew at its end goes on counting; told with where that end is."""
    kind = np.int64 if column.dtype.kind in "iub" else np.float64
    steps = np.diff(column.astype(kind))
    back = steps < 0
    if not back.any() or column.min() < 0 or not (steps > 0).any():
        return column, ""
    usual = float(np.median(steps[steps > 0]))
    for end, word in _COUNTERS.items():
        jumps = steps[back] + end
        if (jumps >= 0).all() and (jumps <= _JUMP * usual).all():
            times = np.append(0, np.cumsum(back))
            unit = kind(end) if kind is np.int64 and end.is_integer() else end
            turns = counted(int(back.sum()), "time")
            return column.astype(kind) + times * unit, f"begun anew at {word} {turns}, counted on"
    return column, ""
