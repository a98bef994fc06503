"""Steps that Newton's method brings to a limit that is the end of a range, or close to it.

A sine is 1 where two or three numbers are right to eight digits: varied at random, they never are.
"""

from typing import Any

import numpy as np

from tuner.code.array_step import Step
from tuner.code.bases import Bases, above, missing
from tuner.code.by_one_entry import Place, entries, places_of
from tuner.code.states import Arrays

_MOVED, _TURNS = 4, 24
"""Entries that are moved together, and how often."""
_FIRST, _LEAST, _LONGEST = 0.1, 1e-9, 4.0
"""Distance of the points that tell the derivatives, over the size of an entry, at first and at
least; and the longest move over that."""
_DAMPED = np.array([1e-9, 1e-3, 1e-2, 0.1, 1.0, 10.0])
"""What is added to the curvature, over the largest."""


def by_newton(
    step: Step, own: int, bases: Bases, side: np.ndarray, draw: np.random.Generator
) -> Arrays:
    """Steps that a few entries bring as far beyond the limit as they can, or as close to it.

    Args:
        step: the filter's.
        own: number of fields of the state.
        bases: steps and their limits.
        side: 1 for steps that begin above the limit, -1 for the others.
        draw: a generator.
    """
    best = [x.copy() for x in bases.steps]
    places = _moved(step, own, bases, draw)
    size = np.zeros((len(side), _MOVED))
    for at, own_places in enumerate(places):
        size[at, : len(own_places)] = [_size(best, at, one) for one in own_places]
    reach = np.full(len(side), _FIRST)

    def apart(moves: np.ndarray, *, mattering: bool = False) -> np.ndarray:
        """The distances before the limit after moves ``(bases, P, entries)``, ``(bases, P)``."""
        count = moves.shape[1]
        tried = [np.repeat(x, count, axis=0) for x in best]
        for at, own_places in enumerate(places):
            rows = slice(at * count, (at + 1) * count)
            for k, (field, index) in enumerate(own_places):
                place: Any = (rows, *index)
                tried[field][place] += moves[at, :, k] * size[at, k]
        gap, found = missing(step, own, tried, bases, np.repeat(side, count))
        worst = ~np.isfinite(gap) if mattering else ~np.isfinite(found)
        return np.where(worst, np.inf, found).reshape(len(side), count)

    for _ in range(_TURNS):
        points = _STENCIL[None] * reach[:, None, None]
        moves = _newton(apart(points)) * reach[:, None, None]
        found = apart(np.concatenate([0 * moves[:, :1], moves], axis=1), mattering=True)
        which = found.argmin(axis=1)
        chosen = np.where(which[:, None] > 0, moves[np.arange(len(side)), which - 1], 0.0)
        for at, own_places in enumerate(places):
            for k, (field, index) in enumerate(own_places):
                best[field][(at, *index)] += chosen[at, k] * size[at, k]
        length = np.abs(chosen).max(axis=1)
        reach = np.clip(np.where(which > 0, length, reach / 8), _LEAST, _FIRST)
    return best


def _stencil() -> np.ndarray:
    """The middle, a step to either side along each entry, and one along each two of them."""
    unit = np.eye(_MOVED)
    pairs = [unit[i] + unit[j] for i in range(_MOVED) for j in range(i)]
    return np.array([0 * unit[0], *unit, *-unit, *pairs])


_STENCIL = _stencil()


def _newton(values: np.ndarray) -> np.ndarray:
    """The moves to the least value of parabolas, damped more and more, over the points' distance.

    Args:
        values: at the points, ``(bases, P)``.
    """
    n = _MOVED
    with np.errstate(all="ignore"):
        middle, ahead, behind = values[:, :1], values[:, 1 : 1 + n], values[:, 1 + n : 1 + 2 * n]
        slope = (ahead - behind) / 2
        curved = np.zeros((len(values), n, n))
        curved[:, range(n), range(n)] = ahead + behind - 2 * middle
        pairs = [(i, j) for i in range(n) for j in range(i)]
        for at, (i, j) in enumerate(pairs):
            both = values[:, 1 + 2 * n + at] - ahead[:, i] - ahead[:, j] + middle[:, 0]
            curved[:, i, j] = curved[:, j, i] = both
    slope, curved = (np.where(np.isfinite(x), x, 0.0) for x in (slope, curved))
    sizes, turn = np.linalg.eigh(curved)
    most = np.maximum(np.abs(sizes).max(axis=1), np.abs(slope).max(axis=1))[:, None, None]
    along = np.einsum("bij,bi->bj", turn, slope)
    least = np.abs(sizes)[:, None] + _DAMPED[None, :, None] * np.where(most > 0, most, 1.0)
    moves = -np.einsum("bij,bcj->bci", turn, along[:, None] / least)
    length = np.abs(moves).max(axis=2, keepdims=True)
    return np.asarray(moves * np.minimum(1.0, _LONGEST / np.maximum(length, _LONGEST)))


def _moved(step: Step, own: int, bases: Bases, draw: np.random.Generator) -> list[list[Place]]:
    """Some entries for each base, of those that its decision depends on by the fewest operations.

    Chosen by chance: the more one moves what is compared, the rather.
    """
    known, near = places_of(step), list[list[Place]]()
    for at, one in enumerate(bases.compared):
        some = entries(step, one, known)
        near.append([place for place in some if np.isfinite(_entry(bases.steps, at, place))])
    most = 1 + max(map(len, near), default=0)
    moved = [np.repeat(x, most, axis=0) for x in bases.steps]
    for at, places in enumerate(near):
        for k, (field, index) in enumerate(places):
            moved[field][(at * most + k, *index)] += _FIRST * _size(bases.steps, at, places[k])
    with np.errstate(all="ignore"):
        x, limit, _ = above(step, own, moved, bases)
        apart = (x - limit).reshape(len(near), most)
        by = np.nan_to_num(np.abs(apart - apart[:, -1:]), posinf=0) + np.finfo(float).tiny
    by *= draw.exponential(size=by.shape)
    return [
        [places[k] for k in np.argsort(-row[: len(places)])[:_MOVED]]
        for places, row in zip(near, by, strict=True)
    ]


def _entry(steps: Arrays, at: int, place: Place) -> float:
    field, index = place
    return float(steps[field][(at, *index)])


def _size(steps: Arrays, at: int, place: Place) -> float:
    """The size of an entry, or where it is zero of the largest in its field, or one."""
    own = abs(_entry(steps, at, place))
    return own or float(np.abs(np.nan_to_num(steps[place[0]][at])).max(initial=0)) or 1.0
