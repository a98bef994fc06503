"""Tests of constant noise: over time, and over the level."""

from typing import NamedTuple

import numpy as np

from tuner.diagnostics.column import PARTS, Column
from tuner.diagnostics.finding import Finding, judged, not_tried

TIME, TIME_WHAT = "over time", "largest distance of the sum of scores from a straight line"
LEVEL, LEVEL_WHAT = "over level", "correlation of scores with the level's rank, over its deviation"
FEW = 40
"""The fewest numbers for a test."""
NEIGHBOURS = 10


class Scores(NamedTuple):
    """Normal scores of the sizes of numbers: by their ranks, less the mean.

    Attributes:
        values: ``(n,)``.
        deviation: of each, as it enters the variance of their sum.
    """

    values: np.ndarray
    deviation: float


def scores(column: Column) -> Scores:
    """Klotz's scores of the sizes: squares of normal quantiles.

    Outliers and heavy tails have no say beyond their rank, and of normal numbers nothing is lost
    (Klotz, Annals of Mathematical Statistics 33, 1962). Correlation of the numbers widens the sum,
    and so does that of their sizes over ten neighbours, as an outlier's aftermath has it.
    """
    from scipy.special import ndtri

    from tuner.distributions import ranks

    shares = ranks(np.abs(column.e)) / (len(column) + 1)
    values = ndtri((1 + shares) / 2) ** 2
    values = values - values.mean()
    wider = max(column.spread, _variance_inflation(values, _bounds(column)))
    return Scores(values, float(np.sqrt(np.mean(values**2) * wider)))


def _variance_inflation(values: np.ndarray, bounds: np.ndarray) -> float:
    """Factor by which correlation of neighbours increases the variance of a sum of scores.

    Each is taken less its part's mean, for slow changes are the subject of the test.
    """
    means = np.add.reduceat(values, bounds[:-1]) / np.diff(bounds)
    rest = values - np.repeat(means, np.diff(bounds))
    power, bound, total = rest @ rest, 2 / np.sqrt(len(rest)), 1.0
    for lag in range(1, min(NEIGHBOURS, len(rest) // 5) + 1):
        correlation = float(rest[lag:] @ rest[:-lag] / power) if power > 0 else 0.0
        if correlation < bound:
            break
        total += 2 * correlation
    return total


def over_time(columns: tuple[Column, ...], way: str) -> Finding:
    """Test whether the noise changes with time, or from recording to recording.

    Two looks: the largest distance of the sum of scores from a straight line (sum of squares
    of Brown, Durbin and Evans 1975; Kolmogorov's distribution), which finds steps and trends, and
    the spread of ten parts' means, which finds what comes and goes.

    Args:
        columns: the measurements.
        way: the way out, in words.
    """
    from tuner.distributions import chi_square_above, kolmogorov_above

    found = []
    columns = tuple(c for c in columns if len(c) >= FEW and c.e.any())
    for column in columns:
        values, deviation = scores(column)
        if not deviation > 0:
            continue
        course = float(np.abs(np.cumsum(values)).max() / deviation / np.sqrt(len(column)))
        bounds = _bounds(column)
        means = np.add.reduceat(values, bounds[:-1]) / np.diff(bounds)
        parts = float(np.diff(bounds) @ means**2 / deviation**2)
        chances = kolmogorov_above(course), chi_square_above(parts, len(means) - 1)
        found.append((2 * len(columns) * float(min(chances)), course, column))
    if not found:
        return not_tried(TIME, TIME_WHAT, f"a measurement needs {FEW} innovations")
    p, course, column = min(found, key=lambda each: each[0])
    bounds = _bounds(column)
    sizes = np.add.reduceat(column.e**2, bounds[:-1]) / np.diff(bounds)
    least, most = int(np.argmin(sizes)), int(np.argmax(sizes))
    words = [_span(column, sizes, bounds, i) for i in (least, most)]
    details = {"lowest": float(sizes[least]), "highest": float(sizes[most])}
    sentence = f"the noise{_of(column)} changes with time (NIS {words[0]}, {words[1]}); {way}"
    return judged(TIME, TIME_WHAT, course, p, sentence, details)


def over_level(columns: tuple[Column, ...], unit: str, way: str) -> Finding:
    """Test whether the noise grows or falls with the level, or with its size if it has both signs.

    The level is what was predicted, for that knows nothing of the number's own noise.

    Args:
        columns: the measurements.
        unit: of the levels.
        way: the way out, in words.
    """
    from tuner.distributions import normal_above

    known = [c for c in columns if c.levels is not None and len(c) >= FEW]
    given = [(c, scores(c)) for c in known if c.e.any()]
    looks = [(c, at, own) for c, own in given for at in _levels(c) if np.ptp(at) > 0]
    if not looks:
        why = "the level is unknown" if not known else "the level is constant"
        return not_tried(LEVEL, LEVEL_WHAT, why)
    statistics = [_rank_correlation(own, at) for _, at, own in looks]
    worst = int(np.argmax(np.abs(statistics)))
    column, at, _ = looks[worst]
    order = np.argsort(at, kind="stable")
    thirds = [order[: len(order) // 3], order[-(len(order) // 3) :]]
    sizes = [float(np.mean(column.e[rows] ** 2)) for rows in thirds]
    ranges = [f"{at[rows].min():.3g} to {at[rows].max():.3g} {unit}".rstrip() for rows in thirds]
    sentence = (
        f"the noise{_of(column)} {'grows' if statistics[worst] > 0 else 'falls'} with the level "
        f"(NIS {sizes[0]:.3g} at {ranges[0]}, {sizes[1]:.3g} at {ranges[1]}); {way}"
    )
    p = 2 * len(looks) * float(normal_above(abs(statistics[worst])))
    details = {"lower_third": sizes[0], "upper_third": sizes[1]}
    return judged(LEVEL, LEVEL_WHAT, statistics[worst], p, sentence, details)


def _rank_correlation(found: Scores, level: np.ndarray) -> float:
    """The correlation of the scores with the ranks of levels, over its deviation."""
    from tuner.distributions import ranks

    values, deviation = found
    places = ranks(level)
    places = places - places.mean()
    size = deviation * np.sqrt(places @ places)
    return float(values @ places / size) if size > 0 else 0.0


def _levels(column: Column) -> list[np.ndarray]:
    """The level, and its size where it has both signs."""
    level = np.asarray(column.levels)
    return [level, np.abs(level)] if level.min() < 0 < level.max() else [level]


def _bounds(column: Column) -> np.ndarray:
    """Boundaries of ten parts, or of the recordings where there are enough."""
    count = len(column)
    starts = np.flatnonzero(np.diff(column.recording, prepend=-1))
    if len(starts) > 2 and count >= FEW // 2 * len(starts):
        return np.append(starts, count)
    return np.linspace(0, count, min(PARTS, max(count // 20, 2)) + 1).astype(int)


def _span(column: Column, sizes: np.ndarray, bounds: np.ndarray, i: int) -> str:
    first, last = bounds[i], bounds[i + 1] - 1
    number = column.recording[first]
    if column.recording[-1] > 0 and (column.recording == number).sum() == last - first + 1:
        return f"{sizes[i]:.3g} in recording {number + 1}"
    return f"{sizes[i]:.3g} from {_when(column, first)} to {_when(column, last)}"


def _when(column: Column, index: int) -> str:
    words = f"{column.times[index]:.5g} s"
    if column.recording[-1] > 0:
        words += f" of recording {column.recording[index] + 1}"
    return words


def _of(column: Column) -> str:
    return f" of {column.name}" if column.name else ""
