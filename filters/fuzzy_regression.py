"""Tanaka's possibilistic regression, exact and inside a time loop.

For samples x_j at t_j it minimises sum_j c'abs(t_j) with abs(x_j - p't_j) <= (1 - h) (c'abs(t_j) -
e_j) and c >= 0, t_j with a leading 1 (Tanaka, Uejima and Asai, IEEE Trans. SMC 12(6), 1982).
:func:`regression` takes any t; :func:`line` is the short way for crisp samples at equal distances.
"""

from functools import cache
from itertools import combinations
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from filters.linear_program import optimum

DECIDED = 1e-9
"""With t and x scaled to 1, a multiplier above this is more than rounding."""


class Regression(NamedTuple):
    """Possibilistic regressions of s signals: center p'(1, t) and spread c'abs(1, t).

    Attributes:
        center, spread: p and c, the intercept first, ``(s, k + 1)`` each.
        unique: whether it is certain that no other (p, c) is as good, ``(s,)``. Where it is
            not, because samples tie, one of the best is given, or, where t determines no
            center, something arbitrary; :func:`tuner.tanaka` tells these apart. Samples that
            are not finite, h outside 0 to below 1 and spreads below 0 make everything NaN.
    """

    center: Array
    spread: Array
    unique: Array


def regression(t: Array, x: Array, h: Array | float = 0.0, e: Array | None = None) -> Regression:
    """The narrowest bands about p'(1, t) that hold all samples to the degree h.

    Where it is unique its first derivatives by t, x, h and e are exact, forwards and backwards.

    Args:
        t: regressors without the intercept, any signs: ``(m,)``, ``(m, k)``, or ``(m, k, s)`` where
            every signal has its own.
        x: centres of the samples of s signals, ``(m, s)``.
        h: degree to which the samples have to belong to the band, 0 to below 1.
        e: spreads of the samples, not negative, ``(m, s)``; 0 (crisp) if left out.

    Raises:
        ValueError: for no samples.

    >>> found = regression(jnp.arange(3.0), jnp.array([[1.0], [3.0], [5.0]]))
    >>> found.center.round(12).tolist()
    [[1.0, 2.0]]
    """
    m, signals = x.shape
    if not m:
        raise ValueError("the window is empty; give at least one sample")
    h = _degree(h)
    e = jnp.zeros_like(x) if e is None else jnp.where(e >= 0, e, jnp.nan)
    t = t.reshape(m, -1, 1) if t.ndim < 3 else t
    t = jnp.broadcast_to(t, (*t.shape[:2], signals))
    columns = jnp.concatenate([jnp.ones((m, 1, signals)), t], axis=1)
    # Scales change the coordinates alone, so that nothing depends on them.
    largest = lax.stop_gradient(jnp.abs(columns).max(axis=0))
    scale = jnp.where(largest > 0, largest, 1.0)
    low, high = lax.stop_gradient(((x - e).min(axis=0), (x + e).max(axis=0)))
    size = jnp.where(high > low, high / 2 - low / 2, 1.0)
    middle = low / 2 + high / 2
    columns, centred, room = columns / scale, (x - middle) / size, (1 - h) * e / size
    width = jnp.abs(columns)
    rows = [jnp.concatenate([side * columns, width], axis=1) for side in (1, -1)]
    sides = jnp.concatenate([room + centred, room - centred])
    # s = (1 - h) c
    z, multiplier = optimum(jnp.concatenate(rows), sides, width.sum(axis=0))
    p, s = jnp.split(z * size / jnp.tile(scale, (2, 1)), 2)
    p = p.at[0].add(middle)
    c = jnp.maximum(s, 0.0) / (1 - h)
    finite = jnp.isfinite(p).all(axis=0) & jnp.isfinite(c).all(axis=0)
    return Regression(p.T, c.T, (multiplier > DECIDED) & finite)


def _degree(h: Array | float) -> Array:
    """h, or NaN where it is out of its range."""
    return jnp.where((jnp.asarray(h) >= 0) & (jnp.asarray(h) < 1), h, jnp.nan)


class Line(NamedTuple):
    """A possibilistic line p0 + p1 t with the spread c0 + c1 t, for s signals, ``(s, 2)`` each."""

    center: Array
    spread: Array


def line(window: Array, dt: float, h: Array | float = 0.0) -> Line:
    """:func:`regression` of samples at t = 0, dt, .., without a program.

    The sum of the spreads depends on the band's width at the mean time alone: its edges are the
    lines that support the samples' upper and lower hull there. Where these would cross before the
    first sample, c1 = 0 and the band is the narrowest parallel strip.

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
    h = _degree(h)
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
    weight = jnp.asarray((right - half) / (right - left), window.dtype)[:, None]
    heights = weight * window[left] + (1 - weight) * window[right]
    slopes = (window[right] - window[left]) / _apart(window, dt * (right - left))
    best = jnp.argmax(sign * heights, axis=0)[None]
    return _picked(heights, best), _picked(slopes, best)


def _strip(window: Array, dt: float) -> tuple[Array, Array]:
    """Center ``(s, 2)`` and half width ``(s,)`` of the narrowest parallel strip.

    It is decided by three samples: how far the middle one is from the chord of the others.
    """
    i, j, k = (np.array(part) for part in zip(*_triples(window.shape[0]), strict=True))
    slopes = (window[k] - window[i]) / _apart(window, dt * (k - i))
    off = (window[j] - window[i] - slopes * _apart(window, dt * (j - i))) / 2
    starts = window[i] + off - slopes * _apart(window, dt * i)
    best = jnp.argmax(jnp.abs(off), axis=0)[None]
    center = jnp.stack([_picked(starts, best), _picked(slopes, best)], axis=1)
    return center, jnp.abs(_picked(off, best))


def _apart(window: Array, times: np.ndarray | Array) -> Array:
    """Times beside samples, in the samples' precision, ``(n, 1)``."""
    return jnp.asarray(times, window.dtype)[:, None]


def _picked(values: Array, best: Array) -> Array:
    return jnp.take_along_axis(values, best, axis=0)[0]


@cache
def _across(m: int) -> list[tuple[int, int]]:
    """A sample before the mean time, and one after it."""
    return [(i, j) for i in range(m // 2) for j in range(m // 2, m)]


@cache
def _triples(m: int) -> list[tuple[int, int, int]]:
    return list(combinations(range(m), 3))
