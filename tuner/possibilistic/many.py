"""The regression of many windows that share their t: products with the dual's vertices."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from tuner.possibilistic.one import tanaka
from tuner.possibilistic.vertices import MOST, Vertices, bases, dual_vertices
from tuner.possibilistic.window import window

CHUNK = 256
"""Windows at a time: their values at all vertices stay in the processor's cache."""
_TIE = 1e-12
"""Vertices whose values differ by less than this, of scaled samples in sum, are equally good."""


@dataclass(frozen=True, eq=False)
class Windows:
    """Regressions of W windows, as :class:`tuner.Regression`.

    Attributes:
        center, spread: ``(W, k + 1)``.
        objective: ``(W,)``.
        unique: ``(W,)`` of bool.
    """

    center: np.ndarray
    spread: np.ndarray
    objective: np.ndarray
    unique: np.ndarray


def tanaka_windows(
    t: ArrayLike, x: ArrayLike, h: float = 0.0, e: ArrayLike | None = None
) -> Windows:
    """:func:`tuner.tanaka` for many windows with the same t, exactly and some 50 times as fast.

    Windows with several optima, and a t with too many bases (about 20 samples of one regressor) or
    one that determines no center, are solved one by one.

    Args:
        t: regressors of every window, ``(m,)`` or ``(m, k)``.
        x: samples, ``(W, m)``.
        h: degree to which samples have to belong to the band.
        e: their spreads, ``(W, m)`` or ``(m,)``; 0 if left out.

    Raises:
        ValueError: as :func:`tuner.tanaka`, for every window alike.

    >>> tanaka_windows([0, 1, 2, 3], [[0, 1, 2, 3], [1, 1, 1, 1]]).center.round(9).tolist()
    [[0.0, 1.0], [1.0, 0.0]]
    """
    x = np.asarray(x, float)
    if x.ndim != 2:
        raise ValueError(f"x has the shape {x.shape}; W windows of m samples are (W, m)")
    e = np.zeros_like(x) if e is None else np.broadcast_to(np.asarray(e, float), x.shape)
    n = np.asarray(t, float).reshape(x.shape[1], -1).shape[1] + 1 if x.shape[1] else 1
    found = Windows(
        np.empty((len(x), n)), np.empty((len(x), n)), np.empty(len(x)), np.zeros(len(x), bool)
    )
    rest = np.arange(len(x))
    asked = window(t, x.ravel()[: x.shape[1]], h, None) if len(x) else None
    if asked is not None and asked.of.rank == n and bases(x.shape[1], n) <= MOST:
        _refuse(x, e)
        columns = asked.of.columns * asked.of.scale
        vertices = _vertices(columns.tobytes(), columns.shape)
        for start in range(0, len(x), CHUNK):
            part = slice(start, start + CHUNK)
            _fill(found, part, vertices, x[part], e[part], h)
        rest = np.flatnonzero(~found.unique)
    for i in rest:
        one = tanaka(t, x[i], h, e[i])
        found.center[i], found.spread[i] = one.center, one.spread
        found.objective[i], found.unique[i] = one.objective, one.unique
    return found


@lru_cache(maxsize=8)
def _vertices(columns: bytes, shape: tuple[int, ...]) -> Vertices:
    return dual_vertices(np.frombuffer(columns).reshape(shape))


def _fill(
    found: Windows, part: slice, vertices: Vertices, x: np.ndarray, e: np.ndarray, h: float
) -> None:
    """The windows of a part that have one optimum."""
    low, high = (x - e).min(axis=1), (x + e).max(axis=1)
    size = np.where(high > low, high / 2 - low / 2, 1.0)[:, None]
    middle = (low / 2 + high / 2)[:, None]
    x, e = (x - middle) / size, (1 - h) * e / size
    # Vertices that are not sharp are worth 0 for crisp samples, where the times decide.
    crisp = not e.any() and vertices.decided
    values = x @ vertices.difference[: vertices.sharp if crisp else None].T
    if e.any():
        values += e @ vertices.total.T
    # Of equally good vertices a sharp one knows the solution.
    at = values[:, : vertices.sharp].argmax(axis=1)
    of_sharp = values[np.arange(len(x)), at]
    best = np.maximum(of_sharp, 0.0) if crisp else values.max(axis=1)
    sharp = of_sharp >= best - _TIE * x.shape[1]
    z = np.einsum("wnm,wm->wn", vertices.by_x[at], x)
    if e.any():
        z += np.einsum("wnm,wm->wn", vertices.by_e[at], e)
    n = z.shape[1] // 2
    center = size * z[:, :n]
    center[:, :1] += middle
    found.center[part] = center
    found.spread[part] = np.maximum(size * z[:, n:], 0.0) / (1 - h)
    found.objective[part] = best * size[:, 0] / (1 - h)
    found.unique[part] = sharp


def _refuse(x: np.ndarray, e: np.ndarray) -> None:
    for name, array in (("x", x), ("e", e)):
        if not np.isfinite(array).all():
            w, j = (int(i) for i in np.argwhere(~np.isfinite(array))[0])
            raise ValueError(f"{name} is {array[w, j]} in window {w} at {j}; leave the window out")
    if (e < 0).any():
        raise ValueError(f"a spread e is {e.min():g}; give none below 0")
