"""What a search looks at: steps near and far, and steps beside limits."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from tuner.code.array_step import Step
from tuner.code.expected import LONG
from tuner.code.hidden import Hidden
from tuner.code.limits import beside_limits
from tuner.code.preferred import Preferred
from tuner.code.states import Around, Arrays

_BATCH, _ROUNDS, _FEW = 64, 12, 4
"""States looked at together, and how often: at most, and in the longest steps."""
_POOL = 512
"""States of which in long steps those are taken in which constants reach results that rarely do."""
_LEAST = 4
"""Rounds at least, before only steps beside limits are looked at."""
_OPERATIONS = 72_000
"""Operations that are looked at in all rounds together."""


def batches(
    step: Step, around: Around, draw: np.random.Generator, hidden: Hidden
) -> Iterator[tuple[tuple[Arrays, Arrays], bool]]:
    """States and samples, and whether they are beside limits.

    Args:
        step: the filter's.
        around: where states are drawn.
        draw: a generator.
        hidden: the constants that do not show yet; fewer of them from one batch to the next.
    """
    near, long = replace(around, wide=0.0), len(step.order) > LONG
    rounds = max(_FEW, min(_ROUNDS, _OPERATIONS // len(step.order)))
    own, preferred = len(around.states), None
    for turn in range(rounds):
        drawn = near.drawn(draw, _POOL if long and turn else _BATCH)
        if long and turn:
            preferred = preferred or Preferred(step, hidden.mutants)
            both = preferred.of([*drawn[0], *drawn[1]], hidden.mutants, _BATCH)
            drawn = both[:own], both[own:]
        yield drawn, False
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
