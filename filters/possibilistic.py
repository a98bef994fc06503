"""Tanaka's possibilistic line through equally spaced samples, exact and inside a time loop.

For samples x_j at t_j it minimises sum_j (c0 + c1 t_j) with abs(x_j - p0 - p1 t_j) <= (1 - h)
(c0 + c1 t_j) and c >= 0 (Tanaka, Uejima and Asai, IEEE Trans. SMC 12(6), 1982). The sum depends
on the band's width at the mean time alone: its edges are the lines that support the samples' upper
and lower hull there. Where these would cross before the first sample, c1 = 0 and the band is the
narrowest parallel strip.
"""

from functools import cache
from itertools import combinations
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array


class Line(NamedTuple):
    """A possibilistic line p0 + p1 t with the spread c0 + c1 t, for s signals, ``(s, 2)`` each."""

    center: Array
    spread: Array


def line(window: Array, dt: float, h: Array | float = 0.0) -> Line:
    """Tanaka's line through samples at t = 0, dt, ..

    The derivative is that of the solution where it is unique; at a tie, of one of those that tie.

    Args:
        window: crisp samples of s signals, an even number, ``(m, s)``; of an odd one, one sample
            lies at the mean time, and the line need not be unique.
        dt: their distance.
        h: degree to which the samples have to belong to the line, 0 to below 1.

    Raises:
        ValueError: for an odd number of samples.

    >>> line(jnp.array([[1.0], [3.0], [5.0], [7.0]]), 0.5).center.round(12).tolist()
    [[1.0, 4.0]]
    """
    m = window.shape[0]
    if m % 2 or not m:
        raise ValueError(
            f"a line through {m} equally spaced samples need not be unique; take an even number"
        )
    mean = dt * (m - 1) / 2
    upper, above = _support(window, dt, 1)
    lower, below = _support(window, dt, -1)
    # In the sample's unit, with s = (1 - h) c.
    p1, s1 = (above + below) / 2, (above - below) / 2
    center = jnp.stack([(upper + lower) / 2 - p1 * mean, p1], axis=1)
    spread = jnp.stack([(upper - lower) / 2 - s1 * mean, s1], axis=1)
    if m > 2:
        strip, width = _strip(window, dt)
        crossed = (s1 < 0)[:, None]
        center = jnp.where(crossed, strip, center)
        spread = jnp.where(crossed, jnp.stack([width, 0 * width], axis=1), spread)
    return Line(center, spread / (1 - h))


def _support(window: Array, dt: float, sign: int) -> tuple[Array, Array]:
    """Height at the mean time and slope of the line that supports the hull there, ``(s,)`` each."""
    m = window.shape[0]
    half = (m - 1) / 2
    left, right = (np.array(part) for part in zip(*_across(m), strict=True))
    weight = ((right - half) / (right - left))[:, None]
    heights = weight * window[left] + (1 - weight) * window[right]
    slopes = (window[right] - window[left]) / (dt * (right - left))[:, None]
    best = jnp.argmax(sign * heights, axis=0)[None]
    return _picked(heights, best), _picked(slopes, best)


def _strip(window: Array, dt: float) -> tuple[Array, Array]:
    """Center ``(s, 2)`` and half width ``(s,)`` of the narrowest parallel strip.

    It is decided by three samples: how far the middle one is from the chord of the others.
    """
    i, j, k = (np.array(part) for part in zip(*_triples(window.shape[0]), strict=True))
    slopes = (window[k] - window[i]) / (dt * (k - i))[:, None]
    off = (window[j] - window[i] - slopes * (dt * (j - i))[:, None]) / 2
    starts = window[i] + off - slopes * (dt * i)[:, None]
    best = jnp.argmax(jnp.abs(off), axis=0)[None]
    center = jnp.stack([_picked(starts, best), _picked(slopes, best)], axis=1)
    return center, jnp.abs(_picked(off, best))


def _picked(values: Array, best: Array) -> Array:
    return jnp.take_along_axis(values, best, axis=0)[0]


@cache
def _across(m: int) -> list[tuple[int, int]]:
    """A sample before the mean time, and one after it."""
    return [(i, j) for i in range(m // 2) for j in range(m // 2, m)]


@cache
def _triples(m: int) -> list[tuple[int, int, int]]:
    return list(combinations(range(m), 3))
