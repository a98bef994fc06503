"""Fewer points that look alike."""

from itertools import pairwise

import numpy as np

STEPS = 1e5
"""So many steps of the range are told apart."""


def rows(values: np.ndarray, most: int) -> np.ndarray:
    """Which of many values ``(N,)`` to draw: of every stretch the least and the largest.

    So no peak is lost. Where values are missing, the first of them is kept, which breaks the line.

    >>> values = np.zeros(1000)
    >>> values[333] = 1.0
    >>> shown = rows(values, 20)
    >>> len(shown) <= 20, 333 in shown
    (True, True)
    """
    count = len(values)
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, most // 2 + 1).astype(int)
    chosen = [0, count - 1]
    finite, missing = np.isfinite(values), np.isnan(values)
    bottom, top = (np.where(missing, end, values) for end in (np.inf, -np.inf))
    for low, high in pairwise(edges.tolist()):
        there = finite[low:high]
        if there.any():
            chosen += [low + int(bottom[low:high].argmin()), low + int(top[low:high].argmax())]
        if not there.all():
            chosen.append(low + int(there.argmin()))
    return np.unique(chosen)


def rounded(values: np.ndarray, *, log: bool) -> list[float | None]:
    """Numbers to as many digits as a picture shows; None for what is none.

    >>> rounded(np.array([101322.123456, 101323.0, np.nan]), log=False)
    [101322.12346, 101323.0, None]
    """
    there = np.isfinite(values)
    if not there.any():
        return [None] * len(values)
    if log:
        return [float(f"{x:.6g}") if ok else None for x, ok in zip(values, there, strict=True)]
    span = float(np.ptp(values[there])) or float(np.abs(values[there]).max()) or 1.0
    digits = round(float(np.log10(STEPS) - np.log10(span)))
    short = np.round(values, digits) if digits < 300 else values
    return [float(x) if ok else None for x, ok in zip(short, there, strict=True)]
