"""Whether the first innovations contradict the start: x0 and P0 against the first numbers."""

import numpy as np

from tuner.diagnostics.finding import Finding, judged, not_tried
from tuner.diagnostics.innovations import INSIDE, Column, Innovations

NAME, WHAT = "start", "mean square of the first innovations over the usual one"
FEW = 40
"""Of fewer numbers nothing is said."""
WINDOWS = (1, 2, 4, 8, 16)
CLIPPED = 3.0
"""In deviations; from the second number on, so that one outlier there is no start."""
QUIET = 3
"""A leap after so many numbers is an outlier's; a wrong start shows before, or grows."""


def of_start(innovations: Innovations, way: str) -> Finding:
    """Test whether the first numbers of each recording lie farther off than all.

    Args:
        innovations: they.
        way: the way out, in words.
    """
    from scipy.stats import chi2

    columns = [c for c in innovations.columns if len(c) >= FEW and c.scale > 0]
    looks = []
    for width in WINDOWS:
        squares = [firsts for c in columns if (firsts := _firsts(c, width)).size]
        if squares:
            total, count = sum(s.sum() for s in squares), sum(s.size for s in squares)
            looks.append((float(chi2.sf(total, count)), width, float(total / count)))
    if not looks:
        return not_tried(NAME, WHAT, f"it takes {FEW} innovations of a measurement")
    p, width, mean = min(looks)
    first = max(columns, key=lambda c: abs(c.e[0]) / c.scale)
    largest = float(np.abs(first.e[0]) / first.scale)
    which = "innovation has" if width == 1 else f"{width} innovations have"
    sentence = (
        f"the first {which} {mean:.3g} times the usual square (the very first is "
        f"{largest:.3g} deviations): the start contradicts the first numbers; {way}"
    )
    return judged(NAME, WHAT, mean, len(looks) * p, sentence, {"numbers": float(width)})


def _firsts(column: Column, width: int) -> np.ndarray:
    """Squares of the first numbers of each recording that has enough, over the usual one.

    A recording in which an outlier leaps out of quiet ones among them is left out.
    """
    starts = np.flatnonzero(np.diff(column.recording, prepend=-1))
    lengths = np.diff(np.append(starts, len(column)))
    rows = starts[lengths >= max(FEW // 2, width)][:, None] + np.arange(width)
    sizes = np.abs(column.e[rows]) / column.scale
    leaps = (np.diff(sizes, axis=1) > INSIDE)[:, QUIET - 1 :].any(axis=1)
    later = np.arange(width) > 0
    return np.asarray(np.where(later, np.minimum(sizes, CLIPPED), sizes)[~leaps] ** 2)
