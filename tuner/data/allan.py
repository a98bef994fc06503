"""The overlapping Allan deviation of a record, and how far it can be trusted."""

from dataclasses import dataclass

import numpy as np

from tuner.data.signal import Floats

PER_DECADE = 8
"""Averaging times in a decade."""
_CONFIDENCE = 0.95
_PART = 8192


@dataclass(frozen=True, eq=False)
class AllanCurve:
    """Overlapping Allan deviations, ``(k,)`` each.

    Attributes:
        factors: numbers of samples that are averaged.
        taus: the same as a time, s, rising.
        deviations: in the record's unit.
        freedom: equivalent degrees of freedom of their squares.
        lows: lower 95 % limits.
        highs: upper 95 % limits.
    """

    factors: np.ndarray
    taus: Floats
    deviations: Floats
    freedom: Floats
    lows: Floats
    highs: Floats

    @property
    def variances(self) -> Floats:
        """Allan variances, the record's unit squared."""
        return self.deviations**2


def allan_curve(record: Floats, rate_hz: float) -> AllanCurve:
    """The overlapping Allan deviation from one sample to a third of the record.

    Half the mean square of the difference between two neighbouring means over tau, at every place
    where they fit. The curve's own slope tells the kind of noise, on which the degrees of freedom
    depend. Source: Riley, Handbook of Frequency Stability Analysis, NIST SP 1065, 2008,
    5.2.4 and table 5.

    Args:
        record: even samples, none missing, ``(N,)``, N of at least 9.
        rate_hz: sample rate.

    Raises:
        ValueError: where a sample is missing, or there are too few.

    >>> curve = allan_curve(np.random.default_rng(0).standard_normal(10_000), 100.0)
    >>> bool(np.all(np.abs(curve.deviations[:5] * np.sqrt(100 * curve.taus[:5]) - 1) < 0.1))
    True
    """
    if len(record) < 9 or not np.isfinite(record).all():
        raise ValueError(
            f"an Allan deviation needs 9 samples or more and none missing, and of {len(record)} "
            f"{int((~np.isfinite(record)).sum())} are missing"
        )
    factors = averaging_factors(len(record))
    summed = np.concatenate([[0.0], np.cumsum(record - record.mean())])
    variances = np.array([_variance(summed, int(m)) for m in factors])
    freedom = degrees_of_freedom(len(record), factors, _slopes(factors, variances))
    low, high = chi_square_limits(freedom)
    root = np.sqrt(variances)
    return AllanCurve(
        factors, factors / rate_hz, root, freedom, root * np.sqrt(low), root * np.sqrt(high)
    )


def averaging_factors(samples: int) -> np.ndarray:
    """Numbers of samples to average: from 1 to a third of them, evenly spaced in logarithm.

    >>> averaging_factors(30).tolist()
    [1, 2, 3, 4, 6, 7, 10]
    """
    largest = samples // 3
    steps = np.arange(int(PER_DECADE * np.log10(largest)) + 1) / PER_DECADE
    return np.unique(np.append(np.round(10.0**steps).astype(int), largest))


def degrees_of_freedom(samples: int, factors: np.ndarray, slopes: Floats) -> Floats:
    """Those of an overlapping Allan variance, by the noise that its slope shows (SP 1065 table 5).

    Args:
        samples: how many the record has.
        factors: how many are averaged, ``(k,)``.
        slopes: of ln variance over ln tau, ``(k,)``: about -1 for white noise, 0 for flicker, 1 for
            a random walk.

    >>> degrees_of_freedom(1000, np.array([1, 10]), np.array([-1.0, -1.0])).round(1).tolist()
    [665.8, 146.2]
    """
    n, m = samples + 1.0, factors.astype(float)
    white = (3 * (n - 1) / (2 * m) - 2 * (n - 2) / n) * 4 * m**2 / (4 * m**2 + 5)
    flicker = np.where(m == 1, 2 * (n - 2) ** 2 / (2.3 * n - 4.9), 5 * n**2 / (4 * m * (n + 3 * m)))
    walk = (n - 2) / m * ((n - 1) ** 2 - 3 * m * (n - 1) + 4 * m**2) / (n - 3) ** 2
    found = np.select([slopes < -0.5, slopes < 0.5], [white, flicker], walk)
    return np.asarray(np.maximum(found, 1.0))


def chi_square_limits(freedom: Floats) -> tuple[Floats, Floats]:
    """95 % limits of a variance over its estimate, by its degrees of freedom."""
    from tuner.distributions import chi_square_at

    tail = (1 - _CONFIDENCE) / 2
    return freedom / chi_square_at(1 - tail, freedom), freedom / chi_square_at(tail, freedom)


def _variance(summed: Floats, m: int) -> float:
    """From the sums up to each sample, ``(N + 1,)``; in parts that stay in the cache."""
    count, total = len(summed) - 2 * m, 0.0
    memory = np.empty(min(_PART, count))
    for start in range(0, count, _PART):
        size = min(_PART, count - start)
        first, middle, last = (summed[start + k * m :][:size] for k in range(3))
        second = memory[:size]
        np.subtract(last, middle, out=second)
        second -= middle
        second += first
        total += float(second @ second)
    return total / (2 * count * m * m)


def _slopes(factors: np.ndarray, variances: Floats) -> Floats:
    """Of ln variance over ln tau around each point, by a line through it and two to each side."""
    x, y = np.log(factors), np.log(np.maximum(variances, np.finfo(float).tiny))
    found = [
        np.polyfit(x[low : low + 5], y[low : low + 5], 1)[0]
        for low in np.clip(np.arange(len(x)) - 2, 0, max(len(x) - 5, 0))
    ]
    return np.asarray(found)
