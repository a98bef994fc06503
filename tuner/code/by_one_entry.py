"""Steps that one entry brings beyond a limit: all else, and what follows from it, stays."""

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np

from tuner.code.array_step import Step
from tuner.code.bases import Bases, above, missing
from tuner.code.compared import Compared
from tuner.code.fields import Field
from tuner.code.states import Arrays

_LANES, _MOST = 128, 16
"""Steps that are tried from one, and the most entries that are moved in them."""
_SMALLEST, _LARGEST = -4.0, 3.0
"""Powers of ten of the moves, over the entry and over the limit."""
_PAST = 0.01
"""What is added to a move by the distance from the limit, over the limit: what is counted is past
it then, and what is compared itself."""


def by_one_entry(step: Step, own: int, bases: Bases, side: np.ndarray) -> tuple[Arrays, np.ndarray]:
    """Steps beyond the limit in which one entry is moved, and which they are; others as given.

    Of several the one closest to the limit.

    Args:
        step: the filter's.
        own: number of fields of the state.
        bases: steps and their limits.
        side: 1 for steps that begin above the limit, -1 for the others.
    """
    x, limit, _ = above(step, own, bases.steps, bases)
    moved = [np.repeat(x, _LANES, axis=0) for x in bases.steps]
    places = places_of(step)
    entries_of = {one: entries(step, one, places) for one in dict.fromkeys(bases.compared)}
    for at, one in enumerate(bases.compared):
        for k, (field, index) in enumerate(entries_of[one]):
            rows = np.arange(at * _LANES + k, (at + 1) * _LANES, len(entries_of[one]))
            by = _moves(len(rows), bases.steps[field][at][index], limit[at], x[at] - limit[at])
            place: Any = (rows, *index)
            moved[field][place] += by
    short, apart = missing(step, own, moved, bases, np.repeat(side, _LANES))
    apart = np.where(short > 0, np.inf, np.abs(apart)).reshape(len(side), _LANES)
    there = np.asarray(np.isfinite(apart).any(axis=1))
    rows = np.arange(len(side)) * _LANES + apart.argmin(axis=1)
    pairs = zip(bases.steps, moved, strict=True)
    return [np.where(_along(there, x), y[rows], x) for x, y in pairs], there


Place: TypeAlias = tuple[int, tuple[int, ...]]
"""An entry of a state or sample: its field, and where it stands there."""


def places_of(step: Step) -> dict[int, Place]:
    """The real entries by their nodes; of covariances only variances, which leave it one."""
    program, found = step.program, dict[int, Place]()
    fields: list[Field] = [*program.state, *program.inputs]
    nodes = [*program.known["state"], *program.known["in"]]
    for at, (field, known) in enumerate(zip(fields, nodes, strict=True)):
        for index in field.entries() if field.kind == "real" else ():
            if not field.half or index[0] == index[1]:
                found[int(known[index])] = at, index
    return found


def entries(step: Step, one: Compared, places: Mapping[int, Place]) -> list[Place]:
    """The entries that a decision depends on by the fewest operations."""
    found = list[Place]()
    level = seen = {k for k in (one.x, one.limit) if isinstance(k, int)}
    while level and len(found) < _MOST:
        found += [places[k] for k in sorted(level) if k in places]
        level = {part for k in level for part in step.graph.nodes[k].args} - seen
        seen = seen | level
    return found[:_MOST]


def _moves(count: int, entry: float, limit: float, apart: float) -> np.ndarray:
    """Moves of both signs: by the distance, and of all sizes by the entry and by the limit."""
    at = np.arange(count)
    size = 10 ** np.linspace(_SMALLEST, _LARGEST, count)
    scale = np.where(at // 2 % 2 == 0, np.abs(limit), np.abs(entry) or np.abs(limit))
    moves = np.where(at < 2, np.abs(apart) + _PAST * np.abs(limit), size * scale)
    return np.where(at % 2 == 0, 1.0, -1.0) * moves


def _along(chosen: np.ndarray, x: np.ndarray) -> np.ndarray:
    return chosen[(slice(None),) + (None,) * (x.ndim - 1)]
