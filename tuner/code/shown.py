"""What a batch of steps shows: by a change of each constant, or by derivatives."""

from collections.abc import Hashable
from typing import NamedTuple

import numpy as np

from tuner.code.array_step import Step
from tuner.code.chosen import Also
from tuner.code.detection import FAINT, detected, largest_moves, moves
from tuner.code.evaluation import Given
from tuner.code.expected import SAFE, Expected, comparable, expected, plain
from tuner.code.hidden import Hidden
from tuner.code.mutants import WHOLE, Mutant
from tuner.code.together import Together

_TOGETHER = 96
"""Limits of a long step that are changed together."""
_CLEAR = 10.0
"""The move over its tolerance, of the results together, from which one of them probably shows."""
_SURE = 2.0
"""The move of one result over its tolerance that is seen, though other errors of rounding give
another tolerance."""


class Shown(NamedTuple):
    """What steps show.

    Attributes:
        hidden: which constants that no step before showed, ``(M, B)``.
        also: constants that each shows, found before or not.
        used: uses of results that none showed before, ``(B,)`` each.
        moved: how far constants that hardly show move a result, ``(B,)`` each.
    """

    hidden: np.ndarray
    also: Also
    used: dict[Mutant, np.ndarray]
    moved: dict[Mutant, np.ndarray]


def by_changes(step: Step, given: Given, hidden: Hidden, draw: np.random.Generator) -> Shown:
    """What steps show by a change of each constant."""
    mutants, idle = hidden.mutants, sorted(hidden.idle.intersection(hidden.mutants))
    count = max(map(len, given.values()), default=1)
    sizes = np.zeros((len(mutants), count))
    # Rounding is measured where a change shows at all, which is in few of the later steps.
    exact = plain(step, given)
    hidden.count(exact.values, comparable(step, exact))
    open_ = hidden.open
    some = detected(step, open_, exact, _SURE).any(axis=0)
    idle = sorted(hidden.idle.intersection(open_))
    some |= detected(step, idle, exact, 1.0, change=1.0).any(axis=0)
    if some.any():
        part = {k: x[some] for k, x in given.items()}
        right = expected(step, part, draw, SAFE)
        sizes[:, some] = largest_moves(step, mutants, right)
        doubled = np.atleast_1d(detected(step, idle, right, 1.0, change=1.0).any(axis=1))
        hidden.idle -= {one for one, shows in zip(idle, doubled, strict=True) if shows}
    return Shown(sizes > _SURE, _nothing, {}, dict(zip(mutants, sizes, strict=True)))


def by_derivatives(
    step: Step,
    right: Expected,
    hidden: Hidden,
    draw: np.random.Generator,
    together: Together,
    beside: bool,
) -> Shown:
    """What they show by derivatives, which take one pass for all constants; limits have none.

    Where these leave it open, a constant that is the only one of its operation is changed. Factors
    of what is compared show beside limits, and are looked at only there.
    """
    found = moves(step, right, draw, together.whole, sorted(hidden.uses))
    used = {one: found.pop(one) > _CLEAR for one in sorted(hidden.uses)}
    alone = together.alone - step.limits
    open_ = [one for one in hidden.mutants if one in alone and _is_open(found[one])]
    moved = dict(zip(open_, largest_moves(step, open_, right), strict=True))
    found |= moved
    clear = {one: found[one] > (_SURE if one in moved else _CLEAR) for one in step.mutants}
    shows = np.array([clear[one] for one in hidden.mutants])
    where = step.limits if beside else step.own_limits
    limits = [k for k, one in enumerate(hidden.mutants) if one in where]
    for at in range(0, len(limits), _TOGETHER):
        part = limits[at : at + _TOGETHER]
        shows[part] = detected(step, [hidden.mutants[k] for k in part], right, _SURE)
    seen = dict(zip(hidden.mutants, np.asarray(shows.any(axis=1)), strict=True))
    hidden.idle -= {one for one, shown in seen.items() if shown or found[one].any()}
    rest = {one for one, shown in seen.items() if not shown}
    together.look({one: x for one, x in found.items() if one in rest or one.at == WHOLE})

    def also(at: int) -> list[Hashable]:
        return [one for one, row in clear.items() if row[at]]

    return Shown(shows, also, {one: row for one, row in used.items() if row.any()}, moved)


def _is_open(moves: np.ndarray) -> bool:
    return bool(FAINT < moves.max() <= _CLEAR)


def _nothing(_: int) -> list[Hashable]:
    return []
