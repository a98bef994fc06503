"""The sandwich covariance: scatter of an optimum by the scatter of the samples' contributions."""

from typing import NamedTuple

import numpy as np

from tuner.problem.problem import Problem
from tuner.problem.samples import slopes

SPANS = 8.0
"""Length of the blocks, in correlation times of the slopes."""
BLOCKS = 8
"""The fewest blocks, over all records, that determine a scatter."""


class LongRun(NamedTuple):
    """The covariance of a sum over correlated samples.

    Attributes:
        covariance: ``(n, n)``.
        freedom: degrees of freedom of that estimate, of blocks that overlap.
        block: the length of the blocks, in samples.
    """

    covariance: np.ndarray
    freedom: float
    block: int


def long_run(samples: np.ndarray) -> LongRun:
    """The covariance of the sum of samples ``(N, k, n)`` with mean 0, of k independent records.

    Sums over all blocks of b samples in a row, b being several times the correlation time: the
    overlapping batch means of Meketon and Schmeiser 1984, whose degrees of freedom are 3/2 times
    those of blocks side by side.

    >>> noise = np.random.default_rng(0).standard_normal((4000, 1, 1))
    >>> bool(0.8 < long_run(noise - noise.mean()).covariance[0, 0] / 4000 < 1.2)
    True
    """
    length, records, size = samples.shape
    block = _block(samples)
    sums = np.concatenate([np.zeros((1, records, size)), samples.cumsum(axis=0)])
    within = (sums[block:] - sums[:-block]).reshape(-1, size)
    covariance = within.T @ within / block * (length / (length - block + 1))
    blocks = records * length / block
    # A block's sum has lost the share of the mean that it was taken from.
    covariance = covariance * blocks / max(blocks - 1, 1)
    return LongRun(covariance, 1.5 * (blocks - 1), block)


def _block(samples: np.ndarray) -> int:
    """A block's length: some spans of correlation, but few enough for some blocks to be left."""
    length, records, _ = samples.shape
    span = max(_correlation_time(column) for column in _columns(samples))
    longest = max(int(length * records / BLOCKS), 1)
    return int(np.clip(np.ceil(SPANS * span), round(length ** (1 / 3)), min(longest, length)))


def _columns(samples: np.ndarray) -> np.ndarray:
    """Each coordinate by itself, ``(n, N, k)``."""
    return np.moveaxis(samples, 2, 0)


def _correlation_time(column: np.ndarray) -> float:
    """Sum of the correlations, up to where a pair of them is no longer positive (Geyer 1992).

    Args:
        column: ``(N, k)``.
    """
    length = len(column)
    spectrum = np.fft.rfft(column, 2 * length, axis=0)
    covariance = np.fft.irfft((np.abs(spectrum) ** 2).sum(axis=1))[:length]
    if not covariance[0] > 0:
        return 1.0
    correlation = covariance / covariance[0]
    pairs = correlation[: 2 * (length // 2)].reshape(-1, 2).sum(axis=1)
    ended = np.flatnonzero(pairs <= 0)
    last = ended[0] if len(ended) else len(pairs)
    return float(max(2 * pairs[:last].sum() - 1, 1.0))


def sandwich(problem: Problem, z: np.ndarray, hessian: np.ndarray) -> LongRun | None:
    """The covariance of an optimum z ``(n,)`` of a sum over samples, whatever their distribution.

    H^-1 J H^-1 with J the covariance of the sum of slopes: it holds for innovations that are not
    Gaussian and not independent, where the inverse Hessian alone does not. Source: Huber 1967;
    White, Econometrica 50, 1982.

    Args:
        problem: the problem; its objective is a likelihood or a mean square.
        z: the optimum.
        hessian: of the sum, ``(n, n)``.

    Returns:
        Covariance of z; None where the record is too short.
    """
    each = slopes(problem, z)
    if not np.isfinite(each).all() or each.shape[0] * each.shape[1] < 4 * BLOCKS:
        return None
    found = long_run(each - each.mean(axis=(0, 1)))
    inverse = np.linalg.pinv(hessian, rcond=1e-12, hermitian=True)
    return found._replace(covariance=inverse @ found.covariance @ inverse)
