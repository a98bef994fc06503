"""Fewer points that look alike."""

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
    edges = np.linspace(0, count, max(most // 2, 1) + 1).astype(int)
    width = np.diff(edges).max()
    at = np.minimum(edges[:-1, None] + np.arange(width), edges[1:, None] - 1)
    each, there = np.arange(len(at)), np.isfinite(values)[at]
    missing, inside = np.isnan(values)[at], values[at]
    least = at[each, np.where(missing, np.inf, inside).argmin(axis=1)]
    largest = at[each, np.where(missing, -np.inf, inside).argmax(axis=1)]
    gap = at[each, there.argmin(axis=1)]
    some, broken = there.any(axis=1), ~there.all(axis=1)
    return np.unique([0, count - 1, *least[some], *largest[some], *gap[broken]])


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
