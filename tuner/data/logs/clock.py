"""A time column: its seconds, its usual step, its gaps and its jitter."""

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from tuner.data.logs.epoch import proposed, since_1970
from tuner.data.logs.error import counted
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.table import Floats, Raw
from tuner.data.logs.timename import UNITS, unit_of
from tuner.data.logs.values import Columns, check_finite, factor_of

_GAP = 1.5
_SLOW_S = 1.5
_DIGITS = 9
_MANY = 10
_STRAY = 0.1
_SHARE = 0.2
_SPREAD = 0.6  # of a usual step: two samples in the time of one have a half


@dataclass(frozen=True, eq=False)
class Clock:
    """How a time column runs.

    Attributes:
        seconds: since the first sample, ``(N,)``, rising.
        step: seconds between two samples as a rule; their mean where there is no rule.
        rate_hz: samples per second, the same the other way round.
        gaps: ``(row, seconds)`` of each step above 1.5 times the median; the row before it.
        jitter: largest relative deviation of the other steps from the usual one; 0 where the
            digits of the column explain it.
        steady: whether there is a usual step: four fifths of all are within a tenth of it.
        origin: the first sample's time as the column has it, s; None without a column.
        source: ``column 't'``, ``--rate`` or ``scalar 'fs'``; ``""`` for times that no file has.
        notes: what was taken for granted.
    """

    seconds: Floats
    step: float
    rate_hz: float
    gaps: tuple[tuple[int, float], ...] = ()
    jitter: float = 0.0
    steady: bool = True
    origin: Fraction | None = None
    source: str = ""
    notes: tuple[str, ...] = ()

    @property
    def even(self) -> bool:
        """Whether one step stands for all: none is further off than by a half."""
        return self.steady and not self.gaps and self.jitter <= _GAP - 1.0

    @classmethod
    def rated(
        cls, samples: int, rate_hz: float, source: str = "", notes: tuple[str, ...] = ()
    ) -> "Clock":
        """A clock that only its rate tells."""
        seconds, step = np.arange(samples) / rate_hz, 1.0 / rate_hz
        return cls(seconds, step, float(rate_hz), source=source, notes=notes)


def read_clock(columns: Columns, mapping: Mapping, column: Raw) -> Clock:
    """Judge a raw time column, ``(N,)`` with N of at least 2.

    Raises:
        LogError: where it has missing values, runs backwards or stands still, or is hardly in
            seconds though nothing names another unit.
    """
    check_finite(columns, mapping, column)
    scale, unit_known, note = _scale(columns, mapping, column)
    seconds, resolution = _seconds(column, float(scale))
    _check_rising(columns, mapping, seconds)
    seconds, repeated = _spread(columns, mapping, seconds)
    step = float(np.median(np.diff(seconds)))
    if step > _SLOW_S and not unit_known:
        unit, rate = proposed(step)
        raise columns.error(
            mapping,
            f"steps by {step:g}, which is hardly seconds; name its unit, such as "
            f"--time '{mapping.column}:{unit}' ({rate:.4g} Hz), or :s where it is seconds",
        )
    first = Fraction(column[0].item()) * scale
    spread = f"{counted(repeated, 'repeated time')} spread over their time" * bool(repeated)
    notes = tuple(f"time {mapping.column!r}: {told}" for told in (note, spread) if told)
    return replace(
        judged(seconds, resolution),
        origin=first + Fraction(float(seconds[0])),
        source=f"column {mapping.column!r}",
        notes=notes,
    )


def judged(seconds: Floats, resolution: float = 0.0) -> Clock:
    """The clock of rising times.

    Args:
        seconds: the times, ``(N,)`` with N of at least 2.
        resolution: the step of the digits they were written with.
    """
    steps = np.diff(seconds)
    resolution = resolution + 4.0 * float(np.spacing(np.abs(seconds).max()))
    median = float(np.median(steps))
    gap = steps > _GAP * median
    if gap.sum() >= _MANY and _straight(seconds, resolution):
        gap[:] = False  # steps of one and two last digits: a coarse clock, not lost samples
    if gap.mean() > _SHARE:
        gap[:] = False  # so many are no gaps but the clock's way
    regular = steps[~gap]
    rounded = np.ptp(regular) <= 1.001 * resolution
    stray = np.abs(regular - median) > _STRAY * median
    steady = bool(rounded or stray.mean() <= _SHARE)
    step = median if steady and not rounded else float(regular.mean())
    jitter = 0.0 if rounded else float(np.abs(regular - step).max()) / step
    rows = np.flatnonzero(gap)
    gaps = tuple(zip(rows.tolist(), steps[rows].tolist(), strict=True))
    return Clock(seconds - seconds[0], step, 1.0 / step, gaps, jitter, steady)


def _scale(columns: Columns, mapping: Mapping, column: Raw) -> tuple[Fraction, bool, str]:
    """Seconds per unit of the column, whether anything named the unit, and what was assumed."""
    if mapping.unit is not None and mapping.unit.lower() not in UNITS:
        raise columns.error(
            mapping, f"is in {mapping.unit!r}, no unit of time; use s, ms, us or ns"
        )
    if mapping.unit is not None or mapping.factor is not None:
        factor = Fraction(factor_of(columns, mapping))
        return _exact(mapping.unit or "s") * factor, True, ""
    unit = unit_of(mapping.column.removeprefix(columns.table.prefix))
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


def _check_rising(columns: Columns, mapping: Mapping, seconds: Floats) -> None:
    steps = np.diff(seconds)
    if (steps < 0).any():
        row = int(np.argmax(steps < 0))
        back = f"runs backwards by {-steps[row]:.4g} s at {columns.table.place(row + 1)}"
        rest = "sort the rows by time, or split the log where it was started again"
        raise columns.error(mapping, f"{back}; {rest}, or say with --by what tells the parts apart")
    if not steps.any():
        raise columns.error(mapping, "stands still in all rows; name another --time or --rate HZ")


def _spread(columns: Columns, mapping: Mapping, seconds: Floats) -> tuple[Floats, int]:
    """Samples with the time of the one before, spread over the time that they stand for.

    Loggers write what comes in one burst with the time at which it comes, and clocks that are too
    coarse with the time of the last tick. What fits neither is a row twice, or two recordings.
    """
    new = np.diff(seconds, prepend=-np.inf) > 0
    if new.all():
        return seconds, 0
    rows = np.arange(len(seconds))
    first, last = np.flatnonzero(new), np.flatnonzero(np.append(new[1:], True))
    usual = float(seconds[-1] - seconds[0]) / (len(seconds) - 1)
    before = seconds[0] - usual * (last[0] + 1)
    after = seconds[-1] + usual * (len(seconds) - first[-1])
    since = np.interp(rows, np.append(-1, last), np.append(before, seconds[last]))
    until = np.interp(rows, np.append(first, len(rows)), np.append(seconds[first], after))
    spread = min(since, until, key=lambda times: float(np.diff(times).std()))
    steps = np.diff(spread)
    if steps[~new[1:]].min() < _SPREAD * np.median(steps):
        row = int(np.argmin(new))
        raise columns.error(
            mapping,
            f"stands still at {columns.table.place(row)}, and no pause makes up for it; remove "
            "repeated rows, say with --by what tells recordings apart, or give --rate HZ",
        )
    return spread, int((~new).sum())


def _straight(seconds: Floats, resolution: float) -> bool:
    """Whether the column is a straight line but for the rounding of its digits."""
    rows = np.arange(len(seconds)) - 0.5 * (len(seconds) - 1)
    slope = float(rows @ seconds) / float(rows @ rows)
    return bool(np.ptp(seconds - slope * rows) <= 1.2 * resolution)
