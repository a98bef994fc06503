"""Steps in which a wrong constant shows: a search from states near a filter's own and far off."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.code.array_step import Given, Step
from tuner.code.batches import batches
from tuner.code.chosen import Also, Chosen
from tuner.code.detection import (
    LONG,
    SAFE,
    Expected,
    comparable,
    detected,
    expected,
    moves,
    plain,
    with_others,
)
from tuner.code.hidden import Hidden
from tuner.code.mutants import WHOLE, Mutant
from tuner.code.states import Around, Arrays, by_node, rounded
from tuner.code.together import Inverses, Together

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
        chosen: the same, with what shows in each.
        tried: number of states that were looked at.
        idle: number of constants that had no effect in any of them: not even doubled, or in a long
            step by their derivatives.
    """

    states: Arrays
    samples: Arrays
    chosen: Chosen
    tried: int
    idle: int


def search(step: Step, around: Around, by_jax: Results) -> Found:
    """Steps that together show as many constants as can be.

    Args:
        step: the filter's.
        around: where states are drawn.
        by_jax: JAX's results of steps, with which those of a long step have to agree.
    """
    draw, tried, chosen = np.random.default_rng(0), 0, Chosen()
    program, hidden, together, inverses = step.program, Hidden(step), Together(step), Inverses(step)
    for drawn, beside in batches(step, around, draw, hidden):
        if not hidden.mutants:
            break
        states, samples = (rounded(part, program.precision) for part in drawn)
        given = by_node(program, states, samples)
        tried += len(next(iter(given.values()), ()))
        if len(step.order) > LONG:
            right = with_others(step, expected(step, given, draw), by_jax(states, samples))
            good = comparable(step, right)
            if not good.any():
                continue
            right = right.of(good)
            states, samples = ([x[good] for x in part] for part in (states, samples))
            shows, also, used = _by_derivatives(step, right, hidden, draw, together, beside)
            together.take([*states, *samples], also)
            if beside:
                inverses.look(right, [*states, *samples], also)
        else:
            shows, also, used = _by_changes(step, given, hidden, draw), _nothing, {}
        while shows.any() or used:
            best = int(shows.sum(axis=0).argmax()) if shows.any() else _commonest(used)
            own = [hidden.mutants[k] for k in np.flatnonzero(shows[:, best])]
            more = [one for one, row in used.items() if row[best]]
            chosen.take([x[best] for x in (*states, *samples)], [*own, *also(best)], [], more)
            rest = np.logical_not(shows[:, best])
            hidden.leave(rest)
            hidden.uses.difference_update(more)
            shows, used = shows[rest], {one: row for one, row in used.items() if not row[best]}
        if len(step.order) <= LONG:
            hidden.leave_proven()

    for one, shown in inverses.steps():
        chosen.take(one, shown)
    for one, shown, groups in together.steps():
        chosen.take(one, shown, groups)
    whole, fields = _by_fields(step, chosen.steps), len(program.state)
    return Found(whole[:fields], whole[fields:], chosen, tried, len(hidden.idle))


def _commonest(shown: Mapping[Mutant, np.ndarray]) -> int:
    """The step in which most of these show."""
    return int(np.sum(list(shown.values()), axis=0).argmax())


def _nothing(_: int) -> list[Hashable]:
    return []


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
) -> tuple[np.ndarray, Also, dict[Mutant, np.ndarray]]:
    """The same by derivatives, which take one pass for all constants; limits have none.

    Factors of what is compared show beside limits, and are looked at only there. Also what each
    step shows, found before or not, and where uses of results show that did not yet.
    """
    found = moves(step, right, draw, together.whole, sorted(hidden.uses))
    used = {one: found.pop(one) > _CLEAR for one in sorted(hidden.uses)}
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
    clear = np.array([found[one] > _CLEAR for one in step.mutants])
    used = {one: row for one, row in used.items() if row.any()}
    return shows, lambda at: [step.mutants[k] for k in np.flatnonzero(clear[:, at])], used
