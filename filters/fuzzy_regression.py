"""Tanaka's possibilistic regression, exact and inside a time loop.

For samples x_j at t_j it minimises sum_j c'abs(t_j) with abs(x_j - p't_j) <= (1 - h) (c'abs(t_j) -
e_j) and c >= 0, t_j with a leading 1 (Tanaka, Uejima and Asai, IEEE Trans. SMC 12(6), 1982).
:func:`regression` takes any t; :func:`filters.line` is the short way for crisp samples at equal
distances.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from filters.fuzzy_line import degree
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
    h = degree(h)
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
