"""Distributions by SciPy's special functions: ``scipy.stats`` takes a quarter second to import."""

from typing import Any

import numpy as np
from scipy import special


def chi_square_below(x: Any, degrees: Any) -> Any:
    """The chance of a sum of so many squares of standard normal numbers below x."""
    return special.chdtr(degrees, x)


def chi_square_above(x: Any, degrees: Any) -> Any:
    """The chance of such a sum above x."""
    return special.chdtrc(degrees, x)


def chi_square_at(share: Any, degrees: Any) -> Any:
    """The number below which such a sum lies with a chance.

    >>> float(chi_square_at(0.5, 2).round(6))
    1.386294
    """
    return 2 * special.gammaincinv(np.asarray(degrees) / 2, share)


def student_above(x: Any, degrees: Any) -> Any:
    """The chance of Student's t above x."""
    return special.stdtr(degrees, -np.asarray(x))


def student_at(share: float, degrees: float) -> float:
    """The number below which Student's t lies with a chance.

    >>> round(student_at(0.975, 10), 4)
    2.2281
    """
    return float(special.stdtrit(degrees, share))


def normal_above(x: Any) -> Any:
    """The chance of a standard normal number above x."""
    return special.ndtr(-np.asarray(x))


def more_than(count: int, numbers: int, chance: float) -> float:
    """The chance that of so many numbers, each with a chance, more than ``count`` are taken.

    >>> round(more_than(1, 2, 0.5), 12)
    0.25
    """
    if count < 0:
        return 1.0
    return float(special.betainc(count + 1, numbers - count, chance)) if count < numbers else 0.0


def kolmogorov_above(x: Any) -> Any:
    """The chance of Kolmogorov's statistic, times the root of how many there are, above x."""
    return special.kolmogorov(x)


def ranks(values: np.ndarray) -> np.ndarray:
    """The place of each of N numbers in their order, from 1; equal ones share the mean of theirs.

    >>> ranks(np.array([3.0, 1.0, 3.0])).tolist()
    [2.5, 1.0, 2.5]
    """
    _, which, counts = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(counts) - (counts - 1) / 2)[which])


def heavy_tails(values: np.ndarray) -> float:
    """The chance that normal numbers ``(N,)`` have tails as heavy as these, by their kurtosis.

    Source: Anscombe and Glynn, Distribution of the kurtosis statistic b2 for normal samples,
    Biometrika 70, 1983.
    """
    n = float(len(values))
    apart = values - values.mean()
    kurtosis = np.mean(apart**4) / np.mean(apart**2) ** 2
    mean = 3 * (n - 1) / (n + 1)
    variance = 24 * n * (n - 2) * (n - 3) / ((n + 1) ** 2 * (n + 3) * (n + 5))
    x = (kurtosis - mean) / np.sqrt(variance)
    skewness = 6 * (n * n - 5 * n + 2) / ((n + 7) * (n + 9))
    skewness *= np.sqrt(6 * (n + 3) * (n + 5) / (n * (n - 2) * (n - 3)))
    degrees = 6 + 8 / skewness * (2 / skewness + np.sqrt(1 + 4 / skewness**2))
    root = np.cbrt((1 - 2 / degrees) / (1 + x * np.sqrt(2 / (degrees - 4))))
    usual = 2 / (9 * degrees)
    return float(normal_above((1 - usual - root) / np.sqrt(usual)))
