"""Outliers beyond what normal noise allows."""

import numpy as np

from tuner.diagnostics.column import FEW, INSIDE, Column
from tuner.diagnostics.finding import Finding, judged, not_tried
from tuner.diagnostics.innovations import Innovations

NAME, WHAT = "outliers", "innovations beyond 4 of their usual deviations"


def of_outliers(
    innovations: Innovations, columns: tuple[Column, ...], parts: int, way: str
) -> Finding:
    """Count the innovations beyond 4 deviations, look at the largest, and at the kurtosis.

    The deviation is that of the numbers inside, so that neither many outliers nor wrong variances
    of the filter hide them or make them. A number over the deviation of n others is Student's t;
    the kurtosis (Anscombe and Glynn, Biometrika 70, 1983) finds many that are not so far off.

    Args:
        innovations: of the run.
        columns: their measurements.
        parts: number of parts of the record with a deviation each.
        way: the remedy, in words.
    """
    from tuner.distributions import heavy_tails, more_than, student_above

    columns = tuple(c for c in columns if len(c) >= FEW and c.scale > 0)
    if not columns:
        return not_tried(NAME, WHAT, f"a measurement needs {FEW} innovations")
    sizes = [np.abs(column.e) / column.scale for column in columns]
    count = sum(int((size > INSIDE).sum()) for size in sizes)
    numbers = sum(map(len, columns))
    others = [max(len(c) // parts - 1, 1) for c in columns]
    tails = [len(c) * 2 * student_above(INSIDE, n) for c, n in zip(columns, others, strict=True)]
    expected = float(sum(tails))
    largest = [float(size.max()) for size in sizes]
    single = [
        len(c) * 2 * student_above(x, n) for c, x, n in zip(columns, largest, others, strict=True)
    ]
    heavy = [heavy_tails(c.e) for c in columns]
    chances = (
        more_than(count - 1, numbers, expected / numbers),
        len(columns) * float(min(single)),
        len(columns) * min(heavy),
    )
    first = int(np.argmin(single))
    place = int(np.argmax(sizes[first]))
    found = (
        f"{count} of {numbers} innovations {'lies' if count == 1 else 'lie'} beyond 4 deviations "
        f"where {expected:.2g} are expected, the largest {largest[first]:.3g} "
        f"{innovations.place(columns[first], place)}"
    )
    kurtosis = max(float(np.mean(c.e**4) / np.mean(c.e**2) ** 2) for c in columns)
    words = (
        found
        if min(chances[:2]) < chances[2] or count > 2 * expected + 2
        else (f"innovations have heavier tails than normal noise (kurtosis {kurtosis:.3g} for 3)")
    )
    details = {"expected": expected, "largest": largest[first], "kurtosis": kurtosis}
    details |= {"time": float(columns[first].times[place])}
    return judged(NAME, WHAT, count, 3 * min(chances), f"{words}: outliers; {way}", details)


def outlying(column: Column) -> np.ndarray:
    """Which numbers lie beyond 4 deviations, the one before lying within."""
    beyond = np.abs(column.e) > INSIDE * column.scale
    before = np.concatenate([[False], beyond[:-1] & (np.diff(column.recording) == 0)])
    return np.asarray(beyond & ~before)
