"""Steps in which a wrong constant shows: a search from states near a filter's own and far off."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import TypeAlias

import numpy as np

from tuner.code.array_step import Given, Step
from tuner.code.detection import (
    LONG,
    SAFE,
    Expected,
    agree,
    comparable,
    detected,
    expected,
    moves,
    plain,
)
from tuner.code.hidden import Hidden
from tuner.code.limits import beside_limits
from tuner.code.mutants import WHOLE
from tuner.code.states import Around, Arrays, by_node, rounded
from tuner.code.together import Inverses, Together

_BATCH, _ROUNDS, _FEW = 64, 12, 4
"""States looked at together, and how often: at most, and in the longest steps."""
_LEAST = 4
"""Rounds at least, before only steps beside limits are looked at."""
_OPERATIONS = 72_000
"""Operations that are looked at in all rounds together."""
_TOGETHER = 96
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
    program, hidden, together, inverses = step.program, Hidden(step), Together(step), Inverses(step)
    for drawn, beside in _batches(step, around, draw, hidden):
        if not hidden.mutants:
            break
        states, samples = (rounded(part, program.precision) for part in drawn)
        given = by_node(program, states, samples)
        tried += len(next(iter(given.values()), ()))
        if len(step.order) > LONG:
            right = expected(step, given, draw)
            same = [agree(step, right, found) for found in by_jax(states, samples)]
            right = replace(right, steady=np.logical_and.reduce([right.steady, *same]))
            good = comparable(step, right)
            if not good.any():
                continue
            right = right.of(good)
            states, samples = ([x[good] for x in part] for part in (states, samples))
            shows = _by_derivatives(step, right, hidden, draw, together, beside)
            together.take([*states, *samples])
            if beside:
                inverses.look(right, [*states, *samples])
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

    for gain, more in ((1, inverses.steps()), (0, together.steps())):
        for one in more:
            chosen.append(one)
            gains.append(gain)
    kept = np.sort(np.argsort(-np.array(gains, int), kind="stable")[:most])
    whole, own = _by_fields(step, [chosen[at] for at in kept]), len(program.state)
    return Found(whole[:own], whole[own:], len(kept), tried, len(hidden.idle))


def _by_fields(step: Step, chosen: list[Arrays]) -> Arrays:
    """Steps as an array for each field of the state, then of the inputs."""
    fields = [*step.program.state, *step.program.inputs]
    columns = ([one[k] for one in chosen] for k in range(len(fields)))
    return [
        np.array(column).reshape(len(chosen), *field.shape)
        for column, field in zip(columns, fields, strict=True)
    ]


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
        right = expected(step, part, draw, SAFE)
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
    beside: bool,
) -> np.ndarray:
    """The same by derivatives, which take one pass for all constants; limits have none.

    Factors of what is compared show beside limits, and are looked at only there.
    """
    found = moves(step, right, draw, together.whole)
    sizes = np.array([found[one] for one in hidden.mutants])
    shows = sizes > _CLEAR
    where = step.limits if beside else step.own_limits
    limits = [k for k, one in enumerate(hidden.mutants) if one in where]
    for at in range(0, len(limits), _TOGETHER):
        part = limits[at : at + _TOGETHER]
        shows[part] = detected(step, [hidden.mutants[k] for k in part], right, 2.0)
    seen = np.asarray(shows.any(axis=1))
    moved = np.flatnonzero(seen | sizes.any(axis=1))
    hidden.idle -= {hidden.mutants[k] for k in moved}
    rest = {one for one, shown in zip(hidden.mutants, seen, strict=True) if not shown}
    together.look({one: x for one, x in found.items() if one in rest or one.at == WHOLE})
    return shows


def _batches(
    step: Step, around: Around, draw: np.random.Generator, hidden: Hidden
) -> Iterator[tuple[tuple[Arrays, Arrays], bool]]:
    """States and samples, and whether they are beside limits."""
    near, long = replace(around, wide=False), len(step.order) > LONG
    rounds = max(_FEW, min(_ROUNDS, _OPERATIONS // len(step.order)))
    for turn in range(rounds):
        yield near.drawn(draw, _BATCH), False
        if not long and turn + 1 >= _LEAST and hidden.only_at_limits:
            break
    if not long:
        for moving in (False, True):
            wanted = hidden.wanted(moving=moving)
            batches = beside_limits(step, near, draw, wanted, by_one=moving)
            yield from ((one, True) for one in batches)
    else:
        limits = {one.node for one in hidden.mutants if one in step.limits}
        limits |= {k for k in step.order if step.graph.nodes[k].op == "round"}
        batches = islice(beside_limits(step, near, draw, limits), rounds // 2)
        yield from ((one, True) for one in batches)
        if around.wide:
            yield around.drawn(draw, _BATCH), False
