"""Outliers beyond what normal noise allows."""

import numpy as np

from tuner.diagnostics.finding import Finding, judged, not_tried
from tuner.diagnostics.innovations import INSIDE, Column, Innovations

NAME, WHAT = "outliers", "innovations beyond 4 of their usual deviations"
FEW = 20
"""Of fewer numbers nothing is said."""


def of_outliers(innovations: Innovations, way: str) -> Finding:
    """Count the innovations beyond 4 deviations, and look at the largest.

    A deviation is that of the numbers inside, so that neither many outliers nor wrong variances
    of the filter hide them or make them. A number over the deviation of n others is Student's t.

    Args:
        innovations: they.
        way: the way out, in words.
    """
    from scipy.stats import binom, t

    columns = [c for c in innovations.columns if len(c) >= FEW and c.scale > 0]
    if not columns:
        return not_tried(NAME, WHAT, f"it takes {FEW} innovations of a measurement")
    sizes = [np.abs(column.e) / column.scale for column in columns]
    count = sum(int((size > INSIDE).sum()) for size in sizes)
    numbers = sum(map(len, columns))
    share = sum(len(c) * 2 * t.sf(INSIDE, len(c) - 1) for c in columns) / numbers
    largest = [float(size.max()) for size in sizes]
    single = [len(c) * 2 * t.sf(x, len(c) - 1) for c, x in zip(columns, largest, strict=True)]
    first = int(np.argmin(single))
    p = 2 * min(float(binom.sf(count - 1, numbers, share)), len(columns) * float(min(single)))
    where = innovations.place(columns[first], int(np.argmax(sizes[first])))
    beyond = f"{count} of {numbers} innovations lie beyond 4 deviations"
    sentence = (
        f"{beyond} where {numbers * share:.2g} are expected, the largest {largest[first]:.3g} "
        f"{where}: outliers; {way}"
    )
    details = {"expected": float(numbers * share), "largest": largest[first]}
    details |= {"time": float(columns[first].times[int(np.argmax(sizes[first]))])}
    return judged(NAME, WHAT, count, p, sentence, details)


def outlying(column: Column) -> np.ndarray:
    """Which numbers lie beyond 4 deviations, the one before lying within."""
    beyond = np.abs(column.e) > INSIDE * column.scale
    before = np.concatenate([[False], beyond[:-1] & (np.diff(column.recording) == 0)])
    return np.asarray(beyond & ~before)
