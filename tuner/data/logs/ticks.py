"""Time columns as seconds: numbers in any unit, dates, times of day, and sums of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.date_columns import past_midnight, read_dates
from tuner.data.logs.digits import Resolution
from tuner.data.logs.epoch import since_1970
from tuner.data.logs.error import LogError
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.moments import Ticks
from tuner.data.logs.steps import Steps, rises, since_first
from tuner.data.logs.table import Raw
from tuner.data.logs.timename import UNITS, unit_of
from tuner.data.logs.values import HUGE, Columns, check_finite, factor_of, pick
from tuner.names import counted

_NS = Fraction(1, 10**9)
_JUMP = 20.0  # in usual steps: the samples that may be lost where a counter restarts
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
    """The times of samples, before they are judged.

    Attributes:
        steps: between them, and they themselves, since the first, ``(N,)``.
        first: the first as the columns have it, s.
        resolution: of the digits they were written with.
        known: whether the unit is known.
        notes: what was assumed.
    """

    steps: Steps
    first: Fraction
    resolution: Resolution
    known: bool
    notes: tuple[str, ...]


def read_times(columns: Columns, parts: Sequence[Mapping]) -> Times:
    """The sum of time columns, usually one.

    Raises:
        LogError: where one has missing values, no unit of time, or more than one meaning.
    """
    if len(parts) == 1 and columns.raw[parts[0].column].dtype.kind != "S":
        return _counted(columns, parts[0], pick(columns, parts[0]))
    found = [_nanoseconds(columns, part, parts) for part in parts]
    ticks = np.sum([one.ticks for one in found], axis=0)
    notes = [note for one in found for note in one.notes]
    if all(one.of_day for one in found):
        ticks, past = past_midnight(ticks)
        notes += [f"midnight passed {counted(past, 'time')}"] if past else []
    seconds = (ticks - ticks[0]).astype(np.float64) * 1e-9
    step = 1e-9 * min(one.step for one in found)
    resolution = Resolution.of_step(step)
    return Times(Steps(seconds), int(ticks[0]) * _NS, resolution, True, tuple(notes))


def same_as_before(columns: Columns, parts: Sequence[Mapping]) -> NDArray[np.bool_]:
    """Which rows have the time of the previous row, ``(N,)``."""
    raw = [columns.raw[part.column] for part in parts]
    found = [
        pick(columns, p) if r.dtype.kind != "S" else r for p, r in zip(parts, raw, strict=True)
    ]
    same = [np.append(False, column[1:] == column[:-1]) for column in found]
    return np.asarray(np.logical_and.reduce(same), bool)


@dataclass(frozen=True, eq=False)
class _Part:
    """One of several time columns: ns, step of the last digit, and whether it is a time of day."""

    ticks: Ticks
    step: float
    notes: tuple[str, ...]
    of_day: bool = False


def _nanoseconds(columns: Columns, mapping: Mapping, parts: Sequence[Mapping]) -> _Part:
    column = columns.raw[mapping.column]
    if column.dtype.kind == "S":
        moments, notes = read_dates(columns, mapping, parts)
        return _Part(moments.ticks, moments.step, notes, not moments.dated)
    times = _counted(columns, mapping, pick(columns, mapping), alone=False)
    ticks = np.rint(times.steps.seconds * 1e9).astype(np.int64) + round(times.first / _NS)
    return _Part(ticks, 1e9 * times.resolution.step, times.notes)


def _counted(columns: Columns, mapping: Mapping, column: Raw, *, alone: bool = True) -> Times:
    """Numbers in a unit of time; a single column counts on where it restarts."""
    times = _rising(columns, mapping, column)
    if times is not None:
        return times
    rising = rises(column) and float(column[0]) > -HUGE and float(column[-1]) < HUGE
    if not rising:
        check_finite(columns, mapping, column)
    ends = (column[0], column[-1]) if rising else (column.min(), column.max())
    scale, known, note = _scale(columns, mapping, (float(ends[0]), float(ends[1])))
    column, turned = (column, "") if rising or not alone else _unwrapped(column)
    first = _as_written(column[0]) * scale
    steps = since_first(column, float(scale))
    digits = _resolution(column, scale, ends, (column.min(), column.max()) if turned else ends)
    return Times(steps, first, digits, known, tuple(filter(None, (note, turned))))


def _rising(columns: Columns, mapping: Mapping, column: Raw) -> Times | None:
    """Numbers that rise, as is nearly always so; None for others, which need further passes.

    Whether they rise is seen by their steps, which are looked at anyway.
    """
    if not (len(column) > 1 and -HUGE < float(column[0]) < float(column[-1]) < HUGE):
        return None
    ends = column[0], column[-1]
    try:
        scale, known, note = _scale(columns, mapping, (float(ends[0]), float(ends[1])))
    except LogError:  # missing times are told before
        return None
    steps = since_first(column, float(scale))
    if not steps.lowest > 0:
        return None
    first = _as_written(column[0]) * scale
    digits = _resolution(column, scale, ends, ends)
    return Times(steps, first, digits, known, (note,) if note else ())


def _as_written(number: Any) -> Fraction:
    """A number without rounding, but for that of more than double precision."""
    return Fraction(float(number) if number.dtype.kind == "f" else int(number))


def _scale(
    columns: Columns, mapping: Mapping, ends: tuple[float, float]
) -> tuple[Fraction, bool, str]:
    """Seconds per unit of the column, whether anything named the unit, and what was assumed."""
    if mapping.unit is not None and mapping.unit.lower() not in UNITS:
        raise columns.error(
            mapping, f"is in {mapping.unit!r}, no unit of time; use s, ms, us or ns"
        )
    if mapping.unit is not None or mapping.factor is not None:
        factor = Fraction(factor_of(columns, mapping))
        return _exact(mapping.unit or "s") * factor, True, ""
    written = columns.table.units.get(mapping.column, "")
    unit = unit_of(mapping.column.removeprefix(columns.table.prefix)) or (
        written if written in UNITS else None
    )
    if unit is None and (found := since_1970(*ends)):
        return _exact(found), True, f"taken as {found} since 1970"
    return _exact(unit or "s"), unit is not None, ""


def _exact(unit: str) -> Fraction:
    """Seconds per unit of time, without rounding: 1e-9 is not a double."""
    return Fraction(str(UNITS[unit.lower()]))


def _resolution(
    column: Raw, scale: Fraction, written: tuple[Any, Any], ends: tuple[Any, Any]
) -> Resolution:
    """The resolution of numbers by their lowest and highest, as written and as counted on."""
    largest = max(abs(float(ends[0])), abs(float(ends[1])))
    return Resolution.of_column(column, abs(float(scale)), _rounding(written), largest)


def _rounding(ends: tuple[Any, Any]) -> float:
    """The rounding error of single precision, by the lowest and the highest number."""
    single = ends[0].dtype.kind == "f" and ends[0].dtype.itemsize < 8
    return float(np.spacing(max(abs(ends[0]), abs(ends[1])))) if single else 0.0


def _unwrapped(column: Raw) -> tuple[Raw, str]:
    """Times of a counter that restarted at its end and now counts on, and that end for a note."""
    whole = column.dtype.kind in "iub"
    column = column.astype(np.int64 if whole else np.float64, copy=False)
    if not (column[1:] < column[:-1]).any() or column.min() < 0:
        return column, ""
    steps = np.diff(column)
    back = steps < 0
    if not (steps > 0).any():
        return column, ""
    usual = float(np.median(steps[steps > 0]))
    turns = np.append(0, np.cumsum(back))
    for end, word in _COUNTERS.items():
        jumps = steps[back] + end
        if (jumps >= 0).all() and (jumps <= _JUMP * usual).all():
            note = f"begun anew at {word} {counted(int(back.sum()), 'time')}, counted on"
            return column + turns * (int(end) if whole else end), note
    return column, ""
