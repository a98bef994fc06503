"""Operations of JAX that move entries, on arrays of any objects."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tuner.code.interpreter import Algebra, Arrays, Rule, each, mixed, objects, rows_of
from tuner.code.numbers import MOVED, Move, worked_out
from tuner.code.refused import NoCounterpartError

MOST_WAYS = 16
"""Most entries of a table with an index known at run time; all of them are evaluated."""


def _of_one(move: Move) -> Rule:
    return lambda _, equation, given: [move(given[0], equation.params)]


def _joined(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    return [np.concatenate(mixed(algebra, given), axis=equation.params["dimension"])]


def _stacked(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    return [np.stack(mixed(algebra, given), axis=equation.params["axis"])]


def _parted(_: Algebra, equation: Any, given: Arrays) -> Arrays:
    ends = np.cumsum(equation.params["sizes"])[:-1]
    return list(np.split(given[0], ends, axis=equation.params["axis"]))


def _unstacked(_: Algebra, equation: Any, given: Arrays) -> Arrays:
    return rows_of(given[0], equation.params["axis"])


def _indexed(first: int, last: int = 100) -> Rule:
    """A move along indices, which are found by moving the positions of entries.

    Args:
        first: the first operand with indices.
        last: one beyond the last.
    """

    def rule(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
        if any(array.dtype == object for array in given[first:last]):
            name = equation.primitive.name
            raise NoCounterpartError(f"{name} by an index that is known only as the step runs")
        where = range(first, min(last, len(given)))
        asked = [one if k in where else one.shape for k, one in enumerate(given)]
        found = places(equation, asked)
        moving = [one.ravel() for k, one in enumerate(given) if k not in where]
        entries = np.concatenate([*objects(algebra, moving), np.empty(1, object)])
        if any((place < 0).any() for place in found):
            entries[-1] = algebra.constant(equation.outvars[0].aval.dtype.type(np.nan))
        return [entries[place.ravel()].reshape(place.shape) for place in found]

    return rule


def _by_index(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    """A part of a short table by an index that is known only at run time: one of a few."""
    table, *starts = given
    if all(start.dtype != object for start in starts):
        return _indexed(1)(algebra, equation, given)
    sizes = equation.params["slice_sizes"]
    free = [n - size for n, size in zip(table.shape, sizes, strict=True)]
    ways = [
        range(n + 1) if s.dtype == object else [int(np.clip(s, 0, n))]
        for n, s in zip(free, starts, strict=True)
    ]
    count = math.prod(map(len, ways))
    if count > MOST_WAYS:
        raise NoCounterpartError(
            f"a table of {count} entries by an index that is known only as the step runs has no "
            f"counterpart among scalars; one of {MOST_WAYS} has"
        )
    (entries,) = objects(algebra, [table])

    def part(axis: int, before: tuple[int, ...]) -> np.ndarray:
        """The part chosen by the index of this axis and of those after it."""
        if axis == len(ways):
            whole = [slice(at, at + size) for at, size in zip(before, sizes, strict=True)]
            return entries[tuple(whole)]
        found = [part(axis + 1, (*before, at)) for at in ways[axis]]
        chosen = found[-1]
        for at, one in zip(ways[axis][-2::-1], found[-2::-1], strict=True):
            here = algebra.apply("le", starts[axis][()], algebra.constant(np.int64(at)))
            chosen = each(lambda no, yes, c=here: algebra.choose(c, no, yes), chosen, one)
        return chosen

    return [part(0, ())]


def places(equation: Any, given: Sequence[Any]) -> Arrays:
    """Source of each entry of the results, counted through all operands; -1: none.

    Args:
        equation: the move.
        given: the shape of an operand whose entries move, or the numbers of the indices.
    """
    counted, at, params = [], 0, dict(equation.params)
    for one in given:
        if isinstance(one, tuple):
            counted.append(np.arange(at, at + math.prod(one), dtype=np.int64).reshape(one))
            at += math.prod(one)
        else:
            counted.append(np.asarray(one))
    if "fill_value" in params:
        params["fill_value"] = -1
    return worked_out(equation, counted, params)


def _added(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    """Entries added at given places, each of which occurs once."""
    target, where, more = given
    if where.dtype == object:
        raise NoCounterpartError("scatter-add by an index that is known only as the step runs")
    dtype = equation.invars[0].aval.dtype  # of what JAX traced the addition for
    nothing = np.zeros(target.shape, dtype)
    (met,) = worked_out(equation, [nothing, where, np.ones(more.shape, dtype)])
    if (met > 1).any():
        raise NoCounterpartError("scatter-add of several numbers to one place")
    counted = np.arange(1, more.size + 1, dtype=dtype).reshape(more.shape)
    (hit,) = worked_out(equation, [nothing, where, counted])
    target, more = objects(algebra, (target, more))
    flat = more.ravel()
    return [each(lambda x, k: algebra.apply("add", x, flat[int(k) - 1]) if k else x, target, hit)]


MOVES: Mapping[str, Rule] = {
    **{name: _of_one(move) for name, move in MOVED.items()},
    "concatenate": _joined,
    "stack": _stacked,
    "split": _parted,
    "unstack": _unstacked,
}
"""Moves that apply to numbers and entries alike."""

PLACED: Mapping[str, Rule] = {
    "pad": _indexed(2),
    "gather": _indexed(1),
    "scatter": _indexed(1, 2),
    "dynamic_slice": _by_index,
    "dynamic_update_slice": _indexed(2),
    "scatter-add": _added,
    "scatter_add": _added,
}
"""Moves with indices among their operands."""
