"""Test of the start: whether the first innovations contradict x0 and P0."""

import numpy as np

from tuner.diagnostics.column import INSIDE, Column
from tuner.diagnostics.finding import Finding, judged, not_tried

NAME, WHAT = "start", "mean square of the first innovations over the usual one"
FEW = 40
"""The fewest numbers for a test."""
WINDOWS = (1, 2, 4, 8, 16)
CLIPPED = 3.0
"""Limit in deviations, from the second number on, so that one outlier does not count as a start."""
ENOUGH = 100
QUIET = 3
"""A leap after so many numbers is an outlier's; a wrong start shows before, or grows."""


def of_start(columns: tuple[Column, ...], way: str) -> Finding:
    """Test whether the first numbers of each recording are larger than usual.

    Args:
        columns: the measurements.
        way: the way out, in words.
    """
    from tuner.distributions import chi_square_above

    columns = tuple(c for c in columns if len(c) >= FEW and c.scale > 0)
    looks = []
    for width in WINDOWS:
        squares = [firsts for c in columns if (firsts := _firsts(c, width)).size]
        if squares:
            total, count = sum(s.sum() for s in squares), sum(s.size for s in squares)
            chance = float(chi_square_above(total, count))
            looks.append((chance, width, float(total / count)))
    if not looks:
        return not_tried(NAME, WHAT, f"a measurement needs {FEW} innovations")
    p, width, mean = min(looks)
    first = max(columns, key=lambda c: abs(c.e[0]) / c.scale)
    largest = float(np.abs(first.e[0]) / first.scale)
    which = "innovation has" if width == 1 else f"{width} innovations have"
    sentence = (
        f"the first {which} {mean:.3g} times the usual square (the very first is "
        f"{largest:.3g} deviations): the start contradicts the first numbers; {way}"
    )
    p = max(len(looks) * p, _share_elsewhere(columns, width, mean))
    return judged(NAME, WHAT, mean, p, sentence, {"numbers": float(width)})


def _share_elsewhere(columns: tuple[Column, ...], width: int, mean: float) -> float:
    """The share of as many numbers later on that are as large, for outliers come anywhere.

    Later is the second half; of few numbers it would say too little.
    """
    shares = [0.0]
    for column in columns:
        squares = np.minimum(np.abs(column.e) / column.scale, CLIPPED) ** 2
        means = np.convolve(squares, np.full(width, 1 / width), mode="valid")[len(squares) // 2 :]
        if len(means) > ENOUGH:
            shares.append(float(np.mean(means >= min(mean, CLIPPED**2) * (1 - 1e-9))))
    return max(shares)


def _firsts(column: Column, width: int) -> np.ndarray:
    """Squares of the first numbers of each sufficiently long recording, over the usual square.

    A recording in which an outlier leaps out of quiet ones among them is left out.
    """
    starts = np.flatnonzero(np.diff(column.recording, prepend=-1))
    lengths = np.diff(np.append(starts, len(column)))
    rows = starts[lengths >= max(FEW // 2, width)][:, None] + np.arange(width)
    sizes = np.abs(column.e[rows]) / column.scale
    leaps = (np.diff(sizes, axis=1) > INSIDE)[:, QUIET - 1 :].any(axis=1)
    later = np.arange(width) > 0
    return np.asarray(np.where(later, np.minimum(sizes, CLIPPED), sizes)[~leaps] ** 2)
