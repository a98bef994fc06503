"""Steps that are varied until they are beyond a limit, and brought close to it by bisection."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.code.array_step import Step
from tuner.code.compared import ComparedNumbers
from tuner.code.detection import LONG
from tuner.code.states import Arrays, by_node
from tuner.code.variations import varied

_BESIDE, _CLOSE = (-3e-2, -5e-4, -1e-5, 1e-5, 5e-4, 3e-2), (-5e-4, 5e-4)
"""Distances from a limit, over the limit, and those of a long step: one that is changed passes the
steps that are closer than 1e-3."""
_BEYOND = 1e-3
"""Distance from a limit, over it, from which a step is well beyond."""
_ROUNDS, _KEPT, _CHILDREN, _HALVINGS = 32, 2, 12, 26
_NEARER, _PATIENCE = 0.95, 6
"""A step has come nearer where at most this share of its distance is left; after so many rounds in
which it has not, it is given up; but that of a long filter, which has few."""
Compared: TypeAlias = tuple[int, int, int | float]
"""A comparison, the number that is compared, and its limit: a node, or a half for rounding."""


@dataclass(frozen=True, eq=False)
class Bases:
    """Steps that are to be brought to a limit.

    Attributes:
        compared: at which decision, of each step.
        steps: states and samples, a field each.
        numbers: those that are compared.
    """

    compared: list[Compared]
    steps: Arrays
    numbers: ComparedNumbers


def _above(step: Step, own: int, steps: Arrays, bases: Bases) -> np.ndarray:
    """The number that is compared, and its limit, ``(2, count)``: in as many steps for each base.

    Args:
        step: the filter's.
        own: number of fields of the state.
        steps: those of the first base, then those of the next.
        bases: what is compared.
    """
    given = by_node(step.program, steps[:own], steps[own:])
    return bases.numbers.in_own_steps(given, [one[1:] for one in bases.compared])


def beyond(step: Step, own: int, bases: Bases, draw: np.random.Generator) -> Arrays:
    """Steps on the other side of the limit, or as close to it as variations come."""
    count = len(bases.compared)
    x, limit = _above(step, own, bases.steps, bases)
    side = np.repeat(np.where(x > limit, 1.0, -1.0), _KEPT)
    best = [np.repeat(field, _KEPT, axis=0) for field in bases.steps]
    gap, idle = _gap(step, own, best, bases, side), np.zeros(count, int)
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
        moved = _gap(step, own, children, some, np.repeat(side[rows], _CHILDREN))
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


def _gap(step: Step, own: int, steps: Arrays, bases: Bases, side: np.ndarray) -> np.ndarray:
    """How much is missing to be well beyond the limit."""
    x, limit = _above(step, own, steps, bases)
    with np.errstate(all="ignore"):
        gap = side * (x - limit) + _BEYOND * np.abs(limit)
    return np.where(np.isfinite(gap), np.maximum(gap, 0), np.inf)


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
        x, limit = _above(step, own, between(share), bases)
        with np.errstate(invalid="ignore"):
            return np.asarray(x < goal * limit)

    first, last = below(low), below(high)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        same = below(middle) == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    kept = first != last
    return [x[kept] for x in between(low)]
