"""A time column: its seconds, its usual step, its gaps and its jitter."""

from dataclasses import dataclass

import numpy as np

from tuner.data.logs.mapping import Mapping
from tuner.data.logs.table import Floats, Raw
from tuner.data.logs.timename import UNITS, unit_of
from tuner.data.logs.values import Columns, check_finite, factor_of

_GAP = 1.5
_SLOW_S = 1.5
_DIGITS = 9
_MANY = 10


@dataclass(frozen=True)
class Clock:
    """How a time column runs.

    Attributes:
        step: seconds between two samples as a rule.
        duration_s: from the first sample to the last.
        gaps: ``(row, seconds)`` of each step above 1.5 times the median; the row before it.
        jitter: largest relative deviation of the other steps from the usual one; 0 where the
            digits of the column explain it.
    """

    step: float
    duration_s: float
    gaps: tuple[tuple[int, float], ...]
    jitter: float


def read_clock(columns: Columns, mapping: Mapping, column: Raw) -> Clock:
    """Judge a raw time column, ``(N,)`` with N of at least 2.

    Raises:
        LogError: where it has missing values, does not rise, or is hardly in seconds though
            nothing names another unit.
    """
    check_finite(columns, mapping, column)
    scale, unit_known = _scale(columns, mapping)
    seconds, resolution = _seconds(column, scale)
    steps = np.diff(seconds)
    _check_rising(columns, mapping, steps)
    median = float(np.median(steps))
    if median > _SLOW_S and not unit_known:
        raise columns.error(
            mapping,
            f"steps by {median:g}, which is hardly seconds; name its unit, such as "
            f"--time '{mapping.column}:ms', or :s where it is seconds",
        )
    return _judge(seconds, steps, median, resolution)


def _scale(columns: Columns, mapping: Mapping) -> tuple[float, bool]:
    """Seconds per unit of the column, and whether anything named the unit."""
    if mapping.unit is not None and mapping.unit.lower() not in UNITS:
        raise columns.error(
            mapping, f"is in {mapping.unit!r}, no unit of time; use s, ms, us or ns"
        )
    if mapping.unit is not None or mapping.factor is not None:
        return UNITS[(mapping.unit or "s").lower()] * factor_of(columns, mapping), True
    unit = unit_of(mapping.column)
    return UNITS[unit or "s"], unit is not None


def _seconds(column: Raw, scale: float) -> tuple[Floats, float]:
    """Seconds since the first sample, and the step of the digits they were written with.

    Integers are subtracted as integers: nanoseconds since 1970 do not fit into float64.
    """
    if column.dtype.kind in "iub":
        column, digits = column.astype(np.int64), 1.0
    else:
        column, digits = column.astype(np.float64), _digits(column)
    seconds = (column - column[0]).astype(np.float64) * scale
    return seconds, digits * abs(scale) + 4.0 * float(np.spacing(abs(seconds[-1])))


def _digits(column: Floats) -> float:
    """The step of the last decimal digit in use, 10**-k; rounding alone where there are more."""
    sample = column[:: max(1, len(column) // 1000)]
    noise = 4.0 * float(np.spacing(np.abs(column).max()))
    for decimals in range(_DIGITS + 1):
        if np.abs(sample - np.round(sample, decimals)).max() <= noise:
            return max(10.0**-decimals, noise)
    return noise


def _check_rising(columns: Columns, mapping: Mapping, steps: Floats) -> None:
    if (steps > 0).all():
        return
    row = int(np.argmin(steps > 0))
    place = columns.table.place(row + 1)
    if steps[row] < 0:
        raise columns.error(mapping, f"runs backwards at {place}; sort the rows by time")
    raise columns.error(
        mapping,
        f"stands still at {place}; remove repeated rows, or drop a clock this coarse and give "
        "--rate HZ",
    )


def _judge(seconds: Floats, steps: Floats, median: float, resolution: float) -> Clock:
    gap = steps > _GAP * median
    if gap.sum() >= _MANY and _straight(seconds, resolution):
        gap[:] = False  # steps of one and two last digits: a coarse clock, not lost samples
    regular = steps[~gap]
    rounded = np.ptp(regular) <= 1.001 * resolution
    step = float(regular.mean()) if rounded else median
    jitter = 0.0 if rounded else float(np.abs(regular - median).max()) / median
    rows = np.flatnonzero(gap)
    gaps = tuple(zip(rows.tolist(), steps[rows].tolist(), strict=True))
    return Clock(step, float(seconds[-1]), gaps, jitter)


def _straight(seconds: Floats, resolution: float) -> bool:
    """Whether the column is a straight line but for the rounding of its digits."""
    rows = np.arange(len(seconds)) - 0.5 * (len(seconds) - 1)
    slope = float(rows @ seconds) / float(rows @ rows)
    return bool(np.ptp(seconds - slope * rows) <= 1.2 * resolution)
