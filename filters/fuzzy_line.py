"""Tanaka's possibilistic line through samples at equal distances, without a program.

For samples x_j at t_j it minimises sum_j c0 + c1 t_j with abs(x_j - p0 - p1 t_j) <= (1 - h) (c0 +
c1 t_j) and c >= 0 (Tanaka, Uejima and Asai, IEEE Trans. SMC 12(6), 1982). The sum of the spreads
depends on the band's width at the mean time alone: its edges are the lines that support the
samples' upper and lower hull there. Where these would cross before the first sample, c1 = 0 and the
band is the narrowest parallel strip.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from itertools import combinations
from typing import Any, NamedTuple, TypeAlias, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

_Some = TypeVar("_Some", bound=tuple[Any, ...])
_Pairs: TypeAlias = Mapping[tuple[int, int], Array]
"""A number of each two samples, ``(s,)``."""
COMPARED = 10
"""Samples up to which lines are compared one after another; more take too long to compile."""


class Line(NamedTuple):
    """A possibilistic line p0 + p1 t with the spread c0 + c1 t, for s signals, ``(s, 2)`` each."""

    center: Array
    spread: Array


def line(window: Array, dt: float, h: Array | float = 0.0) -> Line:
    """:func:`filters.regression` of samples at t = 0, dt, ..

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
    _check_even(m)
    return _drawn(window, jnp.asarray(m, window.dtype), (m,), dt, h)


def newest_line(window: Array, taken: Array, dt: float, h: Array | float = 0.0) -> Line:
    """:func:`line` of the newest samples of a window, as many as an even number allows.

    The earliest of them is at t = 0. Where fewer than two have been taken the line is that of the
    last two places of the window.

    Args:
        window: crisp samples of s signals, the newest last, an even number, ``(m, s)``.
        taken: how many samples there have been, ``()``.
        dt: their distance.
        h: degree to which the samples have to belong to the line, 0 to below 1.

    Raises:
        ValueError: for an odd number of samples.

    >>> window = jnp.array([[9.0], [9.0], [1.0], [3.0]])
    >>> newest_line(window, jnp.array(3.0), 0.5).center.round(12).tolist()
    [[1.0, 4.0]]
    """
    m = window.shape[0]
    _check_even(m)
    counts, count = tuple(range(2, m + 1, 2)), jnp.full_like(taken, 2)
    for more in counts[1:]:
        count = jnp.where(taken >= more, more, count)
    return _drawn(window, count, counts, dt, h)


def degree(h: Array | float) -> Array:
    """A degree of membership, or NaN where it is out of its range."""
    return jnp.where((jnp.asarray(h) >= 0) & (jnp.asarray(h) < 1), h, jnp.nan)


def _check_even(m: int) -> None:
    if m % 2 or not m:
        raise ValueError(
            f"a line through {m} equally spaced samples need not be unique; take an even number"
        )


class _Edge(NamedTuple):
    """A line by its height at the mean time and its slope per sample, ``(s,)`` each."""

    height: Array
    slope: Array


class _Chord(NamedTuple):
    """A line through two samples, and the sample between them that is farthest from it.

    Attributes:
        last: height of the line at the newest sample, ``(s,)``.
        slope: per sample, ``(s,)``.
        bend: what the sample is above the line, ``(s,)``.
    """

    last: Array
    slope: Array
    bend: Array


class _Band(NamedTuple):
    """The edges of the band, and the chord that the narrowest parallel strip lies along."""

    upper: _Edge
    lower: _Edge
    chord: _Chord


def _drawn(
    window: Array, count: Array, counts: tuple[int, ...], dt: float, h: Array | float
) -> Line:
    """The line of the newest samples of a window.

    Args:
        window: the samples.
        count: how many of them.
        counts: how many these may be.
        dt, h: as of :func:`line`.
    """
    upper, lower, chord = _band(window, count, counts)
    earlier = count - 1
    # Per sample, with s = (1 - h) c.
    p1, s1 = (upper.slope + lower.slope) / 2, (upper.slope - lower.slope) / 2
    p0 = (upper.height + lower.height) / 2 - p1 * (earlier / 2)
    s0 = (upper.height - lower.height) / 2 - s1 * (earlier / 2)
    strip = chord.last + chord.bend / 2 - chord.slope * earlier
    crossed = s1 < 0
    center = [jnp.where(crossed, strip, p0), jnp.where(crossed, chord.slope, p1) / dt]
    spread = [jnp.where(crossed, jnp.abs(chord.bend) / 2, s0), jnp.where(crossed, 0.0, s1) / dt]
    # A comparison passes over what is not a number.
    used = jnp.arange(window.shape[0])[:, None] >= window.shape[0] - count
    broken = (used & jnp.isnan(window)).any(axis=0)[:, None]
    lines = jnp.stack(center, axis=1), jnp.stack(spread, axis=1) / (1 - degree(h))
    return Line(*(jnp.where(broken, jnp.nan, one) for one in lines))


@partial(jax.custom_jvp, nondiff_argnums=(2,))
def _band(window: Array, count: Array, counts: tuple[int, ...]) -> _Band:
    """The band, of lines that are compared one after another.

    In a time loop that takes a quarter of the time of argmax and gather. Derivatives take argmax,
    beside which the comparisons would be long to compile.
    """
    m = len(window)
    if m > COMPARED:
        return _through(window, _decisive(window, count, counts), count)
    rises = {(i, k): window[k] - window[i] for i, k in combinations(range(m), 2)}
    slopes = {(i, k): rise / (k - i) for (i, k), rise in rises.items()}
    straight = jnp.zeros_like(window[0])
    strip = straight, _Chord(window[-1], slopes[m - 2, m - 1], straight)
    begun, found = m - 2, None
    for used in counts:
        for first in range(begun - 1, m - used - 1, -1):
            strip = _bent(strip, first, window, rises, slopes)
        begun = m - used
        lines = [
            _Edge(window[i] + slopes[i, k] * (_mean(m, used) - i), slopes[i, k])
            for i, k in _across(m, (used,))
        ]
        band = _Band(_farthest(lines, jnp.greater), _farthest(lines, jnp.less), strip[1])
        found = band if found is None else _where(count >= used, band, found)
    assert found is not None
    return found


@_band.defjvp
def _by_samples(
    counts: tuple[int, ...], given: tuple[Array, Array], moved: tuple[Array, Array]
) -> tuple[_Band, _Band]:
    """Which samples decide has no derivative; all else is linear in them."""
    window, count = given
    numbers = _decisive(window, count, counts)
    return _through(window, numbers, count), _through(moved[0], numbers, count)


def _bent(
    strip: tuple[Array, _Chord], first: int, window: Array, rises: _Pairs, slopes: _Pairs
) -> tuple[Array, _Chord]:
    """The size of a bend and its chord, or of one from an earlier sample where that is larger."""
    m = len(window)
    for last in range(first + 2, m):
        slope = slopes[first, last]
        bends = [rises[first, k] - slope * (k - first) for k in range(first + 1, last)]
        bend, size = bends[0], jnp.abs(bends[0])
        for other in bends[1:]:
            farther = jnp.abs(other) > size
            bend, size = _where(farther, (other, jnp.abs(other)), (bend, size))
        own = size, _Chord(window[last] + slope * (m - 1 - last), slope, bend)
        strip = _where(size > strip[0], own, strip)
    return strip


def _farthest(lines: Sequence[_Edge], beyond: Callable[[Array, Array], Array]) -> _Edge:
    """The first of the highest lines at the mean time, or of the lowest."""
    found = lines[0]
    for one in lines[1:]:
        found = _where(beyond(one.height, found.height), one, found)
    return found


class _Decisive(NamedTuple):
    """Numbers of the samples that decide a band.

    Attributes:
        upper, lower: two on each edge that supports the hull at the mean time, ``(2, s)``.
        strip: the two of the chord, and the one between them that is farthest from it, ``(3, s)``.
    """

    upper: Array
    lower: Array
    strip: Array


def _decisive(window: Array, count: Array, counts: tuple[int, ...]) -> _Decisive:
    """By argmax: of equal ones the first, as they are compared one after another."""
    m = len(window)
    first, mean = m - count, _mean(m, count)
    pairs, triples = np.array(_across(m, counts)), np.array(_triples(m))
    (left, right), (i, k) = window[pairs.T], pairs.T[..., None]
    height = left + (right - left) / (k - i) * (mean - i)
    across = (i >= first) & (i < mean) & (k > mean)
    upper, lower = (jnp.where(across, side * height, -jnp.inf).argmax(axis=0) for side in (1, -1))
    (left, right, other), (i, k, j) = window[triples.T], triples.T[..., None]
    size = jnp.abs(other - left - (right - left) / (k - i) * (j - i))
    strip = jnp.where(i >= first, size, -1.0).argmax(axis=0)
    two, three = (jnp.asarray(numbers.T, window.dtype) for numbers in (pairs, triples))
    return _Decisive(two[:, upper], two[:, lower], three[:, strip])


def _through(window: Array, numbers: _Decisive, count: Array) -> _Band:
    """The band through the samples that decide it, linear in these."""
    m = len(window)

    def sample(number: Array) -> Array:
        here = jnp.arange(m, dtype=number.dtype)[:, None] == number
        return jnp.where(here, window, 0.0).sum(axis=0)

    def edge(i: Array, k: Array) -> _Edge:
        left = sample(i)
        slope = (sample(k) - left) / (k - i)
        return _Edge(left + slope * (_mean(m, count) - i), slope)

    i, k, between = numbers.strip
    first, last = sample(i), sample(k)
    slope = (last - first) / (k - i)
    bend = sample(between) - first - slope * (between - i)
    chord = _Chord(last + slope * (m - 1 - k), slope, bend)
    return _Band(edge(*numbers.upper), edge(*numbers.lower), chord)


def _where(chosen: Array, yes: _Some, no: _Some) -> _Some:
    found: _Some = jax.tree.map(partial(jnp.where, chosen), yes, no)
    return found


def _mean(m: int, count: float | Array) -> float | Array:
    """The mean number of the newest samples of m."""
    return m - 1 - (count - 1) / 2


@cache
def _across(m: int, counts: tuple[int, ...]) -> list[tuple[int, int]]:
    """Pairs with a sample before the mean time, and one after it, of some of the newest samples."""
    return [
        (i, k)
        for i, k in combinations(range(m), 2)
        if any(m - count <= i < _mean(m, count) < k for count in counts)
    ]


@cache
def _triples(m: int) -> list[tuple[int, int, int]]:
    """Two samples and one between them, from the newest on; of two alone the last one twice."""
    chords = [(i, k) for i in range(m - 3, -1, -1) for k in range(i + 2, m)]
    return [(m - 2, m - 1, m - 1), *((i, k, j) for i, k in chords for j in range(i + 1, k))]
