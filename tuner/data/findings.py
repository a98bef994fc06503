"""The contents of a channel in numbers: the first thing a user reads about it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_PROBE = 20_000
_CONTINUOUS = 1 << 16
_FINE = 2.0**-24
_PILE = 4
_LEVELS = 3
_RUN = 3


@dataclass(frozen=True)
class Findings:
    """The contents of one channel; all values are in the channel's unit.

    Attributes:
        mean: mean of the samples.
        std: their standard deviation (divided by N).
        minimum: the smallest.
        maximum: the largest.
        resolution: the smallest step between two values that occur; None where they are
            practically continuous (see :func:`resolution`).
        saturated: number of samples at the limit of the range (see :func:`saturation`).
        constant: whether all samples are equal.
        missing: number of missing samples.
    """

    mean: float
    std: float
    minimum: float
    maximum: float
    resolution: float | None
    saturated: int
    constant: bool
    missing: int


def find(samples: Floats) -> Findings:
    """Examine the samples of one channel, ``(N,)``, of which at least one is present.

    >>> found = find(np.array([1.0, np.nan, 3.0]))
    >>> found.mean, found.missing, found.constant
    (2.0, 1, False)
    """
    values = samples[~np.isnan(samples)]
    minimum, maximum = float(values.min()), float(values.max())
    return Findings(
        mean=float(values.mean()),
        std=float(values.std()),
        minimum=minimum,
        maximum=maximum,
        resolution=resolution(values),
        saturated=saturation(values),
        constant=minimum == maximum,
        missing=len(samples) - len(values),
    )


def resolution(values: Floats) -> float | None:
    """The smallest step between values that occur; None where they are practically continuous.

    That is where more than half of the samples or more than 65536 values differ, or where the
    step is finer than 24 bits of the range, and so comes from printed digits.

    Example:
        >>> resolution(np.array([0.0, 0.5, 0.5, 0.0, 2.0, 0.5, 0.0]))
        0.5
    """
    if _distinct(values[:_PROBE]) is None:
        return None
    levels = _distinct(values)
    if levels is None or len(levels) < 2:
        return None
    step = np.diff(levels).min()
    fine = step <= _FINE * (levels[-1] - levels[0])
    return None if fine else float(f"{step:.10g}")


def _distinct(values: Floats) -> Floats | None:
    """The sorted values that occur, where they are few enough for steps to mean something."""
    levels = np.unique(values)
    few = len(levels) <= min(_CONTINUOUS, max(2, len(values) // 2))
    return levels if few else None


def saturation(values: Floats) -> int:
    """Number of samples at an end of the range, in runs of at least 3, as if clipped.

    An end counts where far more samples (4 times) lie on it than on any of the next levels:
    noise thins out towards its extremes however coarse its steps, a clipped signal piles up.
    An end that holds half of all samples is a place of rest rather than a limit.

    Example:
        >>> wave = np.sin(np.linspace(0.0, 20.0, 1000))
        >>> saturation(wave), saturation(np.clip(wave, -2.0, 0.8)) > 100
        (0, True)
    """
    return _saturated_above(values) + _saturated_above(-values)


def _saturated_above(values: Floats) -> int:
    top = values == values.max()
    count = np.count_nonzero(top)
    if count < _RUN or 2 * count >= len(values):
        return 0
    below = values[~top]
    for _ in range(_LEVELS):
        level = below == below.max(initial=-np.inf)
        if not len(below) or _PILE * np.count_nonzero(level) >= count:
            return 0
        below = below[~level]
    return _in_runs(top)


def _in_runs(marked: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> int:
    """Number of marked samples that lie in runs of at least 3."""
    edges = np.flatnonzero(np.diff(marked, prepend=False, append=False))
    lengths = edges[1::2] - edges[::2]
    return int(lengths[lengths >= _RUN].sum())
