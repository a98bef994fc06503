"""Whether one of two filters is better on the same samples: paired, block by block."""

from typing import NamedTuple

import numpy as np

BLOCKS = 24
"""Into so many blocks the samples are parted, where there are enough of them."""
FEWEST = 6
"""Blocks are joined in pairs while neighbours are alike, and so many remain."""
MANY = 8
"""From so many recordings on, each of them is a block: they differ more than their parts."""


class Mean(NamedTuple):
    """A mean and its 95 % interval.

    Attributes:
        value: the mean.
        low, high: its interval; infinite where there are not two blocks.
        blocks: of how many blocks the interval is.
    """

    value: float
    low: float
    high: float
    blocks: int


def block_mean(amounts: np.ndarray, counts: np.ndarray) -> Mean:
    """The mean of amounts over time, with an interval that knows of their correlation.

    The sums over blocks are taken as independent (batch means), the mean as their ratio to what
    counts, and the interval as Student's. Blocks whose neighbours are still alike are joined in
    pairs. Source: Fishman, Management Science 24, 1978; Schmeiser, Operations Research 30, 1982.

    Args:
        amounts: sums over what counts in each sample, ``(N,)`` or, of k recordings, ``(N, k)``.
        counts: how much counts in each, of the same shape.

    >>> found = block_mean(np.arange(100.0) % 2, np.ones(100))
    >>> found.value, found.low < 0.5 < found.high, found.blocks
    (0.5, True, 24)
    """
    from tuner.distributions import student_at

    recordings = [*zip(_columns(amounts), _columns(counts), strict=True)]
    kept = [(a[c > 0], c[c > 0]) for a, c in recordings if (c > 0).any()]
    total = sum(float(c.sum()) for _, c in kept)
    if not total:
        return Mean(float("nan"), -np.inf, np.inf, 0)
    mean = sum(float(a.sum()) for a, _ in kept) / total
    residuals = _residuals(kept, mean)
    count = sum(map(len, residuals))
    if count < 2:
        return Mean(mean, -np.inf, np.inf, count)
    squares = sum(float(r @ r) for r in residuals)
    error = np.sqrt(squares * count / (count - 1)) / total
    reach = float(student_at(0.975, count - 1) * error)
    return Mean(mean, mean - reach, mean + reach, count)


def _columns(array: np.ndarray) -> np.ndarray:
    return np.asarray(array, float).reshape(len(array), -1).T


def _residuals(kept: list[tuple[np.ndarray, np.ndarray]], mean: float) -> list[np.ndarray]:
    """Of each recording its blocks' sums less what the mean makes of them."""
    if len(kept) >= MANY:
        return [np.array([float((a - mean * c).sum()) for a, c in kept])]
    each = max(BLOCKS // len(kept), 1)
    parted = [
        np.array([part.sum() for part in np.array_split(a - mean * c, min(each, len(a)))])
        for a, c in kept
    ]
    while _alike(parted) and sum(map(len, parted)) >= 2 * FEWEST:
        parted = [_joined(sums) for sums in parted]
    return parted


def _alike(parted: list[np.ndarray]) -> bool:
    """Whether neighbouring blocks are more alike than chance makes them."""
    products = sum(float(sums[1:] @ sums[:-1]) for sums in parted)
    squares = sum(float(sums @ sums) for sums in parted)
    return bool(products > squares / np.sqrt(sum(map(len, parted))))


def _joined(sums: np.ndarray) -> np.ndarray:
    if len(sums) < 2:
        return sums
    return np.add.reduceat(sums, np.arange(0, len(sums) - len(sums) % 2, 2))
