"""Tanaka's possibilistic regression, exact and inside a time loop.

For samples x_j at t_j it minimises sum_j c'abs(t_j) with abs(x_j - p't_j) <= (1 - h) (c'abs(t_j) -
e_j) and c >= 0, t_j with a leading 1 (Tanaka, Uejima and Asai, IEEE Trans. SMC 12(6), 1982).
:func:`regression` takes any t; :func:`line` is the short way for crisp samples at equal distances.
"""

from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import combinations
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from filters.linear_program import optimum

Number: TypeAlias = int | Array
"""The number of a sample of a window, or of one for each signal, ``(s,)``."""
Groups: TypeAlias = Sequence[tuple[int, ...]]
"""Numbers of samples that are looked at together."""
Value: TypeAlias = Callable[[Sequence[Array], Sequence[Number]], Array]
"""From the samples of a group and their numbers, ``(s,)``."""
COMPARED = 64
"""Groups that are compared one after another, three out of eight samples; more compile too long."""
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
    _check_even(m)
    return _drawn(window, _decisive(window), m, dt, h)


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
    found, count = _moved(_decisive(window[m - 2 :]), m - 2), jnp.full_like(taken, 2)
    for more in range(4, m + 1, 2):
        longer = _moved(_decisive(window[m - more :]), m - more)
        enough = taken >= more
        found = jax.tree.map(partial(jnp.where, enough), longer, found)
        count = jnp.where(enough, more, count)
    return _drawn(window, found, count, dt, h)


def _check_even(m: int) -> None:
    if m % 2 or not m:
        raise ValueError(
            f"a line through {m} equally spaced samples need not be unique; take an even number"
        )


class _Decisive(NamedTuple):
    """Numbers of the samples that decide a line, ``(s,)`` each.

    Attributes:
        upper, lower: two on each edge that supports the hull at the mean time.
        strip: the three of the narrowest parallel strip, which is decided by how far the middle one
            is from the chord of the others.
    """

    upper: tuple[Array, ...]
    lower: tuple[Array, ...]
    strip: tuple[Array, ...]


def _decisive(window: Array) -> _Decisive:
    m = window.shape[0]
    half, pairs = (m - 1) / 2, _across(m)
    upper = _largest(window, pairs, lambda samples, at: _height(samples, at, half))
    lower = _largest(window, pairs, lambda samples, at: -_height(samples, at, half))
    strip = _largest(window, _triples(m), lambda samples, at: jnp.abs(_bend(samples, at)))
    return _Decisive(upper, lower, strip)


def _moved(found: _Decisive, by: int) -> _Decisive:
    """The same samples, numbered in a window that begins earlier."""
    moved: _Decisive = jax.tree.map(lambda number: number + by, found)
    return moved


def _drawn(
    window: Array, decisive: _Decisive, count: int | Array, dt: float, h: Array | float
) -> Line:
    """The line of the last samples of a window, by those that decide it."""
    first = window.shape[0] - count
    half, mean = first + (count - 1) / 2, dt * (count - 1) / 2
    upper, above = _edge(window, decisive.upper, half, dt)
    lower, below = _edge(window, decisive.lower, half, dt)
    # In the sample's unit, with s = (1 - h) c.
    p1, s1 = (above + below) / 2, (above - below) / 2
    center = jnp.stack([(upper + lower) / 2 - p1 * mean, p1], axis=1)
    spread = jnp.stack([(upper - lower) / 2 - s1 * mean, s1], axis=1)
    samples, (i, *_) = [_chosen(window, number) for number in decisive.strip], decisive.strip
    slope, off = _slope(samples, decisive.strip, dt), _bend(samples, decisive.strip)
    strip = jnp.stack([samples[0] + off - slope * (dt * (i - first)), slope], axis=1)
    crossed = (s1 < 0)[:, None]
    center = jnp.where(crossed, strip, center)
    spread = jnp.where(crossed, jnp.stack([jnp.abs(off), 0 * off], axis=1), spread)
    # A comparison passes over what is not a number.
    used = jnp.arange(window.shape[0])[:, None] >= first
    broken = (used & jnp.isnan(window)).any(axis=0)[:, None]
    spread = spread / (1 - _degree(h))
    return Line(jnp.where(broken, jnp.nan, center), jnp.where(broken, jnp.nan, spread))


def _edge(
    window: Array, numbers: tuple[Array, ...], half: float | Array, dt: float
) -> tuple[Array, Array]:
    """Height at the mean time and slope of the line through two samples, ``(s,)`` each."""
    samples = [_chosen(window, number) for number in numbers]
    return _height(samples, numbers, half), _slope(samples, numbers, dt)


def _height(samples: Sequence[Array], numbers: Sequence[Number], half: float | Array) -> Array:
    (left, right), (i, j) = samples, numbers
    weight = (j - half) / (j - i)
    return weight * left + (1 - weight) * right


def _slope(samples: Sequence[Array], numbers: Sequence[Number], dt: float) -> Array:
    """From the first to the last of some samples."""
    return (samples[-1] - samples[0]) / (dt * (numbers[-1] - numbers[0]))


def _bend(samples: Sequence[Array], numbers: Sequence[Number]) -> Array:
    """Half of what the middle one of three samples is above the chord of the others."""
    (first, middle, last), (i, j, k) = samples, numbers
    return (middle - first - (last - first) / (k - i) * (j - i)) / 2


def _largest(window: Array, groups: Groups, value: Value) -> tuple[Array, ...]:
    """The numbers of the samples for which a value is largest, ``(s,)`` each.

    Args:
        window: the samples, ``(m, s)``.
        groups: the numbers to choose from; of equal values the first counts.
        value: of the samples of a group and their numbers.
    """
    if len(groups) == 1:
        return tuple(jnp.full_like(window[0], number) for number in groups[0])
    if len(groups) > COMPARED:
        return _by_argmax(lax.stop_gradient(window), groups, value)
    found: tuple[Array, ...] = _compared(window, groups, value)
    return found


@partial(jax.custom_jvp, nondiff_argnums=(1, 2))
def _compared(window: Array, groups: Groups, value: Value) -> tuple[Array, ...]:
    """The groups one after another: a quarter of the time of argmax and gather in a time loop.

    Derivatives take argmax, beside which the comparisons would be long to compile.
    """
    values = [value([window[number] for number in group], group) for group in groups]
    best, found = values[0], [jnp.full_like(values[0], number) for number in groups[0]]
    for one, group in zip(values[1:], groups[1:], strict=True):
        larger = one > best
        best = jnp.where(larger, one, best)
        found = [jnp.where(larger, new, old) for new, old in zip(group, found, strict=True)]
    return tuple(found)


@_compared.defjvp
def _unmoved(
    groups: Groups, value: Value, primals: tuple[Array], tangents: tuple[Array]
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Which samples are chosen has no derivative."""
    numbers = _by_argmax(*primals, groups, value)
    return numbers, tuple(jnp.zeros_like(number) for number in numbers)


def _by_argmax(window: Array, groups: Groups, value: Value) -> tuple[Array, ...]:
    columns = [np.array(column) for column in zip(*groups, strict=True)]
    numbers = [jnp.asarray(column, window.dtype)[:, None] for column in columns]
    at = jnp.argmax(value([window[column] for column in columns], numbers), axis=0)
    return tuple(number[at, 0] for number in numbers)


def _chosen(window: Array, number: Array) -> Array:
    """One sample of each signal, by its number, ``(s,)``."""
    sample = window[0]
    for k in range(1, window.shape[0]):
        sample = jnp.where(number == k, window[k], sample)
    return sample


@cache
def _across(m: int) -> list[tuple[int, int]]:
    """A sample before the mean time, and one after it."""
    return [(i, j) for i in range(m // 2) for j in range(m // 2, m)]


@cache
def _triples(m: int) -> list[tuple[int, int, int]]:
    """Three samples; of two, which leave no strip to be chosen, the last one twice."""
    return list(combinations(range(m), 3)) or [(0, 1, 1)]
