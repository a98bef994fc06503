"""Steps that are varied until they are beyond a limit, and brought close to it by bisection."""

import numpy as np

from tuner.code.array_step import Step
from tuner.code.bases import Bases, above, missing
from tuner.code.by_newton import by_newton
from tuner.code.by_one_entry import by_one_entry
from tuner.code.expected import LONG
from tuner.code.states import Arrays
from tuner.code.variations import varied

_BESIDE, _CLOSE = (-3e-2, -5e-4, -1e-5, 1e-5, 5e-4, 3e-2), (-5e-4, 5e-4)
"""Distances from a limit, over the limit, and those of a long step: one that is changed passes the
steps that are closer than 1e-3."""
_ROUNDS, _KEPT, _CHILDREN, _HALVINGS = 32, 2, 12, 26
_NEARER, _PATIENCE = 0.95, 6
"""A step has come nearer where at most this share of its distance is left; after so many rounds in
which it has not, it is given up; but that of a long filter, which has few."""


def beyond(
    step: Step, own: int, bases: Bases, draw: np.random.Generator, *, by_one: bool
) -> Arrays:
    """Steps on the other side of the limit, or as close to it as variations come."""
    x, limit, _ = above(step, own, bases.steps, bases)
    side = np.where(x > limit, 1.0, -1.0)
    if not by_one:
        return _varied(step, own, bases, side, draw)
    found, there = by_one_entry(step, own, bases, side)
    for others in (_varied, by_newton):
        rest = np.flatnonzero(~there)
        if len(rest):
            some = bases.of(rest)
            tried = others(step, own, some, side[rest], draw)
            before, _ = missing(step, own, [x[rest] for x in found], some, side[rest])
            gap, apart = missing(step, own, tried, some, side[rest])
            closer = gap < before
            for field, one in zip(found, tried, strict=True):
                field[rest[closer]] = one[closer]
            there[rest] = closer & (apart < 0)
    return found


def _varied(
    step: Step, own: int, bases: Bases, first: np.ndarray, draw: np.random.Generator
) -> Arrays:
    """The same by variations of all entries, of which the best are varied again."""
    count = len(bases.compared)
    side = np.repeat(first, _KEPT)
    best = [np.repeat(field, _KEPT, axis=0) for field in bases.steps]
    (gap, _), idle = missing(step, own, best, bases, side), np.zeros(count, int)
    patience = _ROUNDS if len(step.order) > LONG else _PATIENCE
    for _ in range(_ROUNDS):
        least = gap[::_KEPT].copy()
        going = np.flatnonzero((least > 0) & (idle < patience))
        if not len(going):
            break
        rows = (going[:, None] * _KEPT + np.arange(_KEPT)).ravel()
        some = Bases([bases.compared[k] for k in going], [], bases.numbers)
        parents = [field[rows] for field in best]
        children = varied(draw, [np.repeat(field, _CHILDREN, axis=0) for field in parents])
        moved, _ = missing(step, own, children, some, np.repeat(side[rows], _CHILDREN))
        both = [_by_base(one, len(going)) for one in (gap[rows], moved)]
        order = np.argsort(np.concatenate(both, axis=1), axis=1, kind="stable")[:, :_KEPT]
        gap[rows] = np.take_along_axis(np.concatenate(both, axis=1), order, axis=1).ravel()
        lanes = np.arange(len(going))[:, None]
        for field, one, other in zip(best, parents, children, strict=True):
            whole = [_by_base(part, len(going)) for part in (one, other)]
            chosen = np.concatenate(whole, axis=1)[lanes, order]
            field[rows] = chosen.reshape(len(rows), *field.shape[1:])
        idle = np.where(gap[::_KEPT] < _NEARER * least, 0, idle + 1)
    return [_by_base(field, count)[:, 0] for field in best]


def _by_base(x: np.ndarray, count: int) -> np.ndarray:
    return x.reshape(count, len(x) // count, *x.shape[1:])


def close(step: Step, own: int, bases: Bases, others: Arrays) -> Arrays:
    """Steps between the two sides, close to the limit, at several distances from it."""
    beside = _CLOSE if len(step.order) > LONG else _BESIDE
    count, ways = len(bases.compared), len(beside)
    ends = [
        (np.repeat(one, ways, axis=0), np.repeat(other, ways, axis=0))
        for one, other in zip(bases.steps, others, strict=True)
    ]
    goal = np.tile(1 + np.array(beside), count)
    low, high = np.zeros(count * ways), np.ones(count * ways)

    def between(share: np.ndarray) -> Arrays:
        return [
            x + share[(slice(None),) + (None,) * (x.ndim - 1)] * (y - x)
            if x.dtype.kind == "f"
            else x
            for x, y in ends
        ]

    def below(share: np.ndarray) -> np.ndarray:
        x, limit, _ = above(step, own, between(share), bases)
        with np.errstate(invalid="ignore"):
            return np.asarray(x < goal * limit)

    first, last = below(low), below(high)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        same = below(middle) == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    kept = first != last
    return [x[kept] for x in between(low)]
