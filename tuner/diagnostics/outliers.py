"""Outliers beyond what normal noise allows."""

from typing import Literal, TypeAlias

import numpy as np

from tuner.diagnostics.finding import Finding, judged, not_tried
from tuner.diagnostics.innovations import INSIDE, Column, Innovations, usual

NAME, WHAT = "outliers", "innovations beyond 4 of their usual deviations"
FEW = 20
"""Of fewer numbers nothing is said."""
PARTS = 10

Varying: TypeAlias = Literal["", "time", "level"]


def of_outliers(innovations: Innovations, way: str, varying: Varying = "") -> Finding:
    """Count the innovations beyond 4 deviations, and look at the largest.

    A deviation is that of the numbers inside, so that neither many outliers nor wrong variances
    of the filter hide them or make them. A number over the deviation of n others is Student's t.

    Args:
        innovations: they.
        way: the way out, in words.
        varying: what the noise changes with: it is then taken in ten parts, for a change of it
            makes no outliers.
    """
    from scipy.stats import binom, t

    columns = [c for c in innovations.columns if len(c) >= FEW and c.scale > 0]
    if not columns:
        return not_tried(NAME, WHAT, f"it takes {FEW} innovations of a measurement")
    parts = [_parts(column, varying) for column in columns]
    sizes = [_sizes(column, of) for column, of in zip(columns, parts, strict=True)]
    count = sum(int((size > INSIDE).sum()) for size in sizes)
    numbers = sum(map(len, columns))
    others = [min(map(len, of)) - 1 for of in parts]
    tails = [2 * t.sf(INSIDE, n) for n in others]
    expected = float(sum(len(c) * tail for c, tail in zip(columns, tails, strict=True)))
    largest = [float(size.max()) for size in sizes]
    single = [len(c) * 2 * t.sf(x, n) for c, x, n in zip(columns, largest, others, strict=True)]
    first = int(np.argmin(single))
    p = 2 * min(
        float(binom.sf(count - 1, numbers, expected / numbers)), len(columns) * float(min(single))
    )
    place = int(np.argmax(sizes[first]))
    sentence = (
        f"{count} of {numbers} innovations lie beyond 4 deviations where {expected:.2g} are "
        f"expected, the largest {largest[first]:.3g} {innovations.place(columns[first], place)}: "
        f"outliers; {way}"
    )
    details = {"expected": expected, "largest": largest[first]}
    details |= {"time": float(columns[first].times[place])}
    return judged(NAME, WHAT, count, p, sentence, details)


def _parts(column: Column, varying: Varying) -> list[np.ndarray]:
    """The rows that have one deviation."""
    rows = np.arange(len(column))
    if varying == "level" and column.levels is not None:
        rows = np.argsort(column.levels, kind="stable")
    return np.array_split(rows, min(PARTS, len(rows) // FEW) if varying else 1)


def _sizes(column: Column, parts: list[np.ndarray]) -> np.ndarray:
    sizes = np.abs(column.e)
    for rows in parts:
        scale = usual(column.e[rows])
        sizes[rows] /= scale if scale > 0 else column.scale
    return sizes


def outlying(column: Column) -> np.ndarray:
    """Which numbers lie beyond 4 deviations, the one before lying within."""
    beyond = np.abs(column.e) > INSIDE * column.scale
    before = np.concatenate([[False], beyond[:-1] & (np.diff(column.recording) == 0)])
    return np.asarray(beyond & ~before)
