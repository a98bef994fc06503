"""Steps in which a wrong constant shows: a search from states near a filter's own and far off."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import TypeAlias

import numpy as np

from tuner.code.array_step import Given, Step
from tuner.code.detection import (
    LONG,
    Expected,
    agree,
    comparable,
    detected,
    expected,
    moves,
    plain,
)
from tuner.code.fields import Field
from tuner.code.hidden import Hidden
from tuner.code.limits import beside_limits
from tuner.code.literal import Precision
from tuner.code.mutants import is_limit
from tuner.code.states import Around, Arrays, by_node
from tuner.code.together import Together

_BATCH, _ROUNDS, _FEW = 64, 12, 4
"""States looked at together, and how often: at most, and in the longest steps."""
_LEAST = 4
"""Rounds at least, before only steps beside limits are looked at."""
_OPERATIONS = 72_000
"""Operations that are looked at in all rounds together."""
_TOGETHER = 32
"""Limits of a long step that are changed together."""
_CLEAR = 10.0
"""The move over its tolerance, of the results together, from which one of them probably shows."""
Results: TypeAlias = Callable[[Arrays, Arrays], Sequence[np.ndarray]]
"""The roots of steps from states and samples, ``(roots, B)``, by each half of symmetric ones."""


@dataclass(frozen=True, eq=False)
class Found:
    """Single steps in which constants show.

    Attributes:
        states, samples: a field each, ``(C, ...)``.
        count: C.
        tried: number of states that were looked at.
        idle: number of constants that had no effect in any of them: not even doubled, or in a long
            step by their derivatives.
    """

    states: Arrays
    samples: Arrays
    count: int
    tried: int
    idle: int


def search(step: Step, around: Around, most: int, by_jax: Results) -> Found:
    """At most so many steps that together show as many constants as can be.

    Args:
        step: the filter's.
        around: where states are drawn.
        most: number of steps.
        by_jax: JAX's results of steps, with which those of a long step have to agree.
    """
    draw, tried, chosen, gains = np.random.default_rng(0), 0, list[Arrays](), list[int]()
    program, hidden, together = step.program, Hidden(step), Together(step)
    for drawn in _batches(step, around, draw, hidden):
        if not hidden.mutants:
            break
        states, samples = (rounded(part, program.precision) for part in drawn)
        given = by_node(program, states, samples)
        tried += len(next(iter(given.values()), ()))
        if len(step.order) > LONG:
            right = expected(step, given, draw)
            same = [agree(step, right, found) for found in by_jax(states, samples)]
            right = replace(right, steady=np.logical_and.reduce([right.steady, *same]))
            shows = _by_derivatives(step, right, hidden, draw, together)
            together.take([*states, *samples])
        else:
            shows = _by_changes(step, given, hidden, draw)
        while shows.any():
            best = int(shows.sum(axis=0).argmax())
            gains.append(int(shows[:, best].sum()))
            chosen.append([x[best] for x in (*states, *samples)])
            rest = np.logical_not(shows[:, best])
            hidden.leave(rest)
            shows = shows[rest]
        if len(step.order) <= LONG:
            hidden.leave_proven()

    for one in together.steps():
        chosen.append(one)
        gains.append(0)
    kept = np.sort(np.argsort(-np.array(gains, int), kind="stable")[:most])
    fields = [*program.state, *program.inputs]
    whole = [
        np.array([chosen[at][k] for at in kept]).reshape(len(kept), *f.shape)
        for k, f in enumerate(fields)
    ]
    own = len(program.state)
    return Found(whole[:own], whole[own:], len(kept), tried, len(hidden.idle))


def _by_changes(step: Step, given: Given, hidden: Hidden, draw: np.random.Generator) -> np.ndarray:
    """Which constants show in which steps, ``(M, B)``, by a change of each."""
    mutants, idle = hidden.mutants, sorted(hidden.idle.intersection(hidden.mutants))
    count = max(map(len, given.values()), default=1)
    whole = np.zeros((len(mutants), count), bool)
    # Rounding is measured where a change shows at all, which is in few of the later steps.
    exact = plain(step, given)
    hidden.count(exact.values, comparable(step, exact))
    open_ = hidden.open
    some = detected(step, open_, exact, 2.0).any(axis=0)
    idle = sorted(hidden.idle.intersection(open_))
    some |= detected(step, idle, exact, 1.0, change=1.0).any(axis=0)
    if some.any():
        part = {k: x[some] for k, x in given.items()}
        right = expected(step, part, draw)
        whole[:, some] = detected(step, mutants, right, 2.0)
        doubled = np.atleast_1d(detected(step, idle, right, 1.0, change=1.0).any(axis=1))
        hidden.idle -= {one for one, shows in zip(idle, doubled, strict=True) if shows}
    return whole


def _by_derivatives(
    step: Step,
    right: Expected,
    hidden: Hidden,
    draw: np.random.Generator,
    together: Together,
) -> np.ndarray:
    """The same by derivatives, which take one pass for all constants; limits have none."""
    found = moves(step, right, draw)
    sizes = np.array([found[one] for one in hidden.mutants])
    shows = sizes > _CLEAR
    limits = [k for k, one in enumerate(hidden.mutants) if is_limit(step.graph, one)]
    for at in range(0, len(limits), _TOGETHER):
        part = limits[at : at + _TOGETHER]
        shows[part] = detected(step, [hidden.mutants[k] for k in part], right, 2.0)
    seen = shows.any(axis=1)
    moved = np.flatnonzero(seen | sizes.any(axis=1))
    hidden.idle -= {hidden.mutants[k] for k in moved}
    together.look({hidden.mutants[k]: sizes[k] for k in np.flatnonzero(~seen)})
    return shows


def _batches(
    step: Step, around: Around, draw: np.random.Generator, hidden: Hidden
) -> Iterator[tuple[Arrays, Arrays]]:
    long = len(step.order) > LONG
    rounds = max(_FEW, min(_ROUNDS, _OPERATIONS // len(step.order)))
    for turn in range(rounds):
        yield around.drawn(draw, _BATCH)
        if not long and turn + 1 >= _LEAST and hidden.only_at_limits:
            break
    if not long:
        yield from beside_limits(step, around, draw, hidden.wanted())
        yield from beside_limits(step, around, draw, hidden.wanted(moving=True))
    else:
        limits = {one.node for one in hidden.mutants if is_limit(step.graph, one)}
        limits |= {k for k in step.order if step.graph.nodes[k].op == "round"}
        yield from islice(beside_limits(step, around, draw, limits), rounds // 2)


def by_field(fields: list[Field], rows: np.ndarray) -> tuple[Arrays, np.ndarray]:
    """Rows of stored entries as arrays ``(B, ...)`` of each field, and the rows that remain."""
    found = []
    for field in fields:
        own, rows = rows[: field.size], rows[field.size :]
        array = np.zeros((own.shape[1], *field.shape))
        for row, index in zip(own, field.entries(), strict=True):
            array[_at(index)] = row
            if field.half:
                array[_at(index[::-1])] = row
        found.append(array)
    return found, rows


def _at(index: tuple[int, ...]) -> tuple[slice | int, ...]:
    return (slice(None), *index)


def rounded(arrays: Arrays, precision: Precision) -> Arrays:
    """Numbers that the precision has."""
    if precision == "double":
        return arrays
    with np.errstate(all="ignore"):
        return [x.astype(np.float32).astype(float) if x.dtype.kind == "f" else x for x in arrays]
