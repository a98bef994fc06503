"""Test of the size of innovations: NIS, and the most likely factor on all noise."""

from typing import NamedTuple

import numpy as np

from tuner.diagnostics.column import Column
from tuner.diagnostics.finding import Finding, judged, not_tried
from tuner.diagnostics.innovations import Innovations

NAME, WHAT = "size", "NIS, the mean of the innovations' squares over their variances"


class Size(NamedTuple):
    """NIS with its expected range, and the factor on all noise variances.

    Attributes:
        nis: mean of y^2 / s over the numbers that count; 1 where the filter is right.
        low, high: range of 95 of 100 consistent filters, with the correlation found here.
        factor: by which all noise variances (Q, R and P0) would have to be multiplied to make the
            innovations likeliest. Innovations do not change with it and their variances grow alike,
            so the likelihood's optimum is the NIS itself.
        factor_low, factor_high: its 95 % interval.
    """

    nis: float
    low: float
    high: float
    factor: float
    factor_low: float
    factor_high: float


NOTHING = Size(*(float("nan"),) * 6)


def size(columns: tuple[Column, ...]) -> Size:
    """The NIS over all numbers of some measurements.

    The squares' mean has the distribution of chi-square over its degrees of freedom, which are the
    numbers over the factor by which correlation widens its variance (Bar-Shalom, Li and
    Kirubarajan 2001, 5.4.2, for white ones).
    """
    from tuner.distributions import chi_square_at

    count = sum(map(len, columns))
    if not count:
        return NOTHING
    with np.errstate(over="ignore"):
        nis = sum(float(c.e @ c.e) for c in columns) / count
    degrees = _degrees(columns)
    low, high = chi_square_at([0.025, 0.975], degrees) / degrees
    return Size(nis, float(low), float(high), nis, nis / float(high), nis / float(low))


def of_size(innovations: Innovations) -> Finding:
    """Test the NIS of all numbers, and of each measurement where there are several."""
    lost: np.ndarray = np.asarray(innovations.lost.any(axis=2))
    if lost.any():
        return _diverged(innovations, lost)
    columns = innovations.columns
    if not columns or not innovations.predicted:
        why = "no innovation counts" if not columns else "the filter predicts no variance"
        return not_tried(NAME, WHAT, why)
    parts = [columns, *((column,) for column in columns)] if len(columns) > 1 else [columns]
    chances = [_chance(part) * len(parts) for part in parts]
    worst = int(np.argmin(chances))
    whole, part = size(columns), size(parts[worst])
    return judged(NAME, WHAT, whole.nis, chances[worst], _sentence(part, parts[worst], columns))


def _degrees(columns: tuple[Column, ...]) -> float:
    return sum(len(column) / column.spread for column in columns)


def _chance(columns: tuple[Column, ...]) -> float:
    """The probability of a NIS so far from 1, on either side."""
    from tuner.distributions import chi_square_above, chi_square_below

    degrees = _degrees(columns)
    at = size(columns).nis * degrees
    return 2 * float(min(chi_square_below(at, degrees), chi_square_above(at, degrees)))


def _sentence(found: Size, part: tuple[Column, ...], columns: tuple[Column, ...]) -> str:
    where = f" of {part[0].name}" if len(part) < len(columns) else ""
    head = f"NIS{where} is {found.nis:.3g}, and {found.low:.3g} to {found.high:.3g} was expected"
    if not found.nis > 0:
        return f"{head}: everything is predicted: too little noise for a test"
    size_, by = ("large", 1 / found.nis) if found.nis < 1 else ("small", found.nis)
    which = f"the variance of {part[0].name}" if where else "all noise variances"
    verb = "is" if where else "are"
    return (
        f"{head}: {which} {verb} too {size_} by a factor {by:.3g}; multiply "
        f"{'it' if where else 'them'} by {found.factor:.3g} ({found.factor_low:.3g} to "
        f"{found.factor_high:.3g})"
    )


def _diverged(innovations: Innovations, lost: np.ndarray) -> Finding:
    row, recording = np.argwhere(lost)[0]
    count = int(innovations.lost.sum())
    when = f"at {innovations.times[row, recording]:.5g} s"
    if lost.shape[1] > 1:
        when += f" of recording {recording + 1}"
    words = (
        f"{count} {'innovation is' if count == 1 else 'innovations are'} not finite, the first "
        f"{when}: the filter diverges with these values; use others"
    )
    return Finding(NAME, WHAT, float("nan"), 0.0, "failed", words)
