"""A time column: its seconds, its usual step, its gaps and its jitter."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from tuner.data.logs.digits import Resolution
from tuner.data.logs.epoch import proposed
from tuner.data.logs.error import quoted
from tuner.data.logs.mapping import Mapping
from tuner.data.logs.steps import Steps
from tuner.data.logs.table import Floats
from tuner.data.logs.ticks import read_times
from tuner.data.logs.usual import Usual
from tuner.data.logs.values import Columns
from tuner.names import counted

_GAP = 1.5
_SLOW_S = 1.5
_MANY = 10
_STRAY = 0.1
_SHARE = 0.2
_DRIFT = 0.01
_SPREAD = 0.6  # share of a usual step: two samples in the time of one have a half


@dataclass(frozen=True, eq=False)
class Clock:
    """The clock of a time column.

    Attributes:
        seconds: since the first sample, ``(N,)``, rising.
        step: usual seconds between two samples; their mean where there is no usual step, or
            where that does not add up to the elapsed time.
        rate_hz: samples per second, the inverse.
        gaps: ``(row, seconds)`` of each step above 1.5 times the median; the row before it.
        jitter: largest relative deviation of the other steps from the usual one; 0 where the
            digits of the column explain it.
        steady: whether there is a usual step: four fifths of all steps are within a tenth of it.
        origin: the first sample's time as the column has it, s; None without a column.
        source: ``column 't'``, ``--rate`` or ``scalar 'fs'``; ``""`` for times that no file has.
        notes: what was assumed.
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
        """Whether one step describes all: none is off by more than a half."""
        return self.steady and not self.gaps and self.jitter <= _GAP - 1.0

    @classmethod
    def rated(
        cls, samples: int, rate_hz: float, source: str = "", notes: tuple[str, ...] = ()
    ) -> "Clock":
        """A clock that is known by its rate only."""
        seconds, step = np.arange(samples, dtype=np.float64), 1.0 / rate_hz
        seconds /= rate_hz  # in place: a long record is large
        return cls(seconds, step, float(rate_hz), source=source, notes=notes)


def read_clock(columns: Columns, parts: Sequence[Mapping]) -> Clock:
    """Judge the sum of time columns, usually one, with at least 2 samples.

    Raises:
        LogError: where it has missing values, runs backwards or stands still, or is hardly in
            seconds though nothing names another unit.
    """
    times, mapping = read_times(columns, parts), parts[-1]
    steps, repeated = times.steps, 0
    if not steps.lowest > 0:
        _check_rising(columns, mapping, steps.seconds)
        seconds, repeated = _spread(columns, mapping, steps.seconds)
        steps = Steps(seconds)
    if not times.known and steps.highest > _SLOW_S and steps.median > _SLOW_S:
        unit, rate = proposed(steps.median)
        raise columns.error(
            mapping,
            f"steps by {steps.median:g}, which is hardly seconds; name its unit, such as "
            f"--time '{mapping.column}:{unit}' ({rate:.4g} Hz), or :s where it is seconds",
        )
    spread = f"{counted(repeated, 'repeated time')} spread over their time" * bool(repeated)
    names = quoted(part.column for part in parts)
    return replace(
        _judged(steps, times.resolution),
        origin=times.first + Fraction(float(steps.seconds[0])),
        source=f"column {names}" if len(parts) == 1 else f"columns {names}",
        notes=tuple(f"time {names}: {note}" for note in (*times.notes, spread) if note),
    )


def judged(seconds: Floats) -> Clock:
    """The clock of rising times, ``(N,)`` with N of at least 2."""
    return _judged(Steps(seconds), Resolution.of_step(0.0))


def _judged(steps: Steps, resolution: Resolution) -> Clock:
    """The clock of steps, and of times with digits of a resolution."""
    seconds = steps.seconds
    since = seconds - seconds[0] if seconds[0] else seconds
    rounding = 4.0 * float(np.spacing(max(abs(seconds[0]), abs(seconds[-1]))))
    apart = steps.highest - steps.lowest
    close = steps.highest <= _GAP * steps.lowest  # than those of the median, which takes longer
    if close and apart <= 1.001 * rounding:
        return Clock(since, steps.mean, 1.0 / steps.mean)
    if resolution.explains(apart, rounding) and (close or steps.highest <= _GAP * steps.median):
        return Clock(since, steps.mean, 1.0 / steps.mean)
    return _uneven(steps, since, resolution, rounding)


def _uneven(steps: Steps, since: Floats, resolution: Resolution, rounding: float) -> Clock:
    """The clock of steps that differ by more than the rounding of their digits."""
    rows, longest = steps.parted(_GAP * steps.median)
    many = len(rows) > _SHARE * len(steps)
    if many or (len(rows) >= _MANY and _straight(steps, resolution, rounding)):
        # So many are not gaps but normal for the clock; steps of one and two last digits are a
        # coarse clock, not lost samples.
        rows, longest = rows[:0], steps.extremes[:, 1]
    usual = Usual(steps, rows, longest)
    rounded = resolution.explains(usual.highest - usual.lowest, rounding)
    steady = rounded or usual.stray(_STRAY * steps.median) <= _SHARE
    close = steady and not rounded and usual.mean_is_near(steps.median, _DRIFT * steps.median)
    step = steps.median if close else usual.mean  # that of alternating steps fits no record
    furthest = max(usual.highest - step, step - usual.lowest)
    jitter = 0.0 if rounded else furthest / step
    lengths = steps.seconds[rows + 1] - steps.seconds[rows]
    gaps = tuple(zip(rows.tolist(), lengths.tolist(), strict=True))
    return Clock(since, step, 1.0 / step, gaps, jitter, steady)


def _check_rising(columns: Columns, mapping: Mapping, seconds: Floats) -> None:
    steps = np.diff(seconds)
    if (steps < 0).any():
        row = int(np.argmax(steps < 0))
        back = f"runs backwards by {-steps[row]:.4g} s at {columns.table.place(row + 1)}"
        rest = "say --by restart where the log was started again there, sort the rows by time"
        raise columns.error(mapping, f"{back}; {rest}, or give --rate HZ")
    if not steps.any():
        raise columns.error(mapping, "stands still in all rows; name another --time or --rate HZ")


def _spread(columns: Columns, mapping: Mapping, seconds: Floats) -> tuple[Floats, int]:
    """Samples with the time of the previous one, spread over the time that they cover.

    Loggers give all samples of a burst the same time, and coarse clocks give the time of the last
    tick. Anything else is a row twice, or two recordings.
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
            f"stands still at {columns.table.place(row)} without a pause after it; give "
            "--drop-repeats for doubled rows, --by COLUMN for several recordings, or --rate HZ",
        )
    return spread, int((~new).sum())


def _straight(steps: Steps, resolution: Resolution, rounding: float) -> bool:
    """Whether the column is a straight line but for the rounding of its digits."""
    largest = 1.2 * (resolution.most + rounding)
    if steps.highest - steps.lowest > 2.0 * (largest + rounding):  # of any line one is off by half
        return False
    seconds = steps.seconds
    rows = np.arange(len(seconds)) - 0.5 * (len(seconds) - 1)
    slope = float(rows @ seconds) / float(rows @ rows)
    return bool(np.ptp(seconds - slope * rows) <= 1.2 * (resolution.step + rounding))
