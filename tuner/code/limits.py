"""Steps in which two numbers that are compared are almost equal.

A limit shows where it just acts, and a series where its argument is largest. So a step is looked
for in which the decision matters: taken otherwise, it changes a result. That step is varied until
it is on the other side, and then brought close to the limit by bisection.
"""

from collections.abc import Collection, Iterator
from itertools import zip_longest

import numpy as np

from tuner.code.approach import beyond, close
from tuner.code.array_step import Step
from tuner.code.bases import Bases
from tuner.code.compared import Compared, ComparedNumbers, reaches
from tuner.code.decided import NOTHING
from tuner.code.detection import detected
from tuner.code.evaluation import Given
from tuner.code.expected import LONG, plain
from tuner.code.mutants import OTHERWISE, Mutant
from tuner.code.operations import COMPARE
from tuner.code.states import Around, Arrays, by_node

_POOLS, _POOL, _BASES, _FEW, _ALL = 3, 256, 4, 64, 64
"""How often so many steps are drawn, in a long step so few, and the most for one limit."""
_BATCH = 128
_EARLY = 3000
"""Operations that a decision of a long step may depend on."""


def beside_limits(
    step: Step,
    around: Around,
    draw: np.random.Generator,
    wanted: Collection[int] | None = None,
    *,
    by_one: bool = True,
    late: bool = False,
) -> Iterator[tuple[Arrays, Arrays]]:
    """States and samples, a field each, in batches.

    Args:
        step: the filter's.
        around: where states are drawn.
        draw: a generator.
        wanted: the operations that compare; None: all.
        by_one: whether one entry alone is moved first, which leaves more as it is, and takes time.
        late: whether what depends on most of a long step is compared as well, which takes longer.
    """
    own = len(around.states)
    bases = _bases(step, around, _compared(step, wanted, late=late), draw)
    if not bases.compared:
        return
    others = beyond(step, own, bases, draw, by_one=by_one)
    near = close(step, own, bases, others)
    found = [np.concatenate(both) for both in zip(near, others, strict=True)]
    for at in range(0, len(found[0]), _BATCH):
        part = [x[at : at + _BATCH] for x in found]
        yield part[:own], part[own:]


def _compared(step: Step, wanted: Collection[int] | None, *, late: bool) -> list[Compared]:
    """Real numbers that are compared, the second no zero and not infinite, and rounded ones.

    So are what a constant is added to and the constant, which shows where neither is much larger.
    In a long step only early ones, unless late ones are asked for, which take long.
    """
    nodes, found = step.graph.nodes, list[Compared]()
    decisions = (k for k in step.order if nodes[k].op != "add")
    for k in decisions if wanted is None else sorted(wanted):
        if nodes[k].op in COMPARE or nodes[k].op in ("max", "min", "add"):
            x, limit = nodes[k].args
            if nodes[x].op == "constant":
                x, limit = limit, x
            real = nodes[x].kind == nodes[limit].kind == "real"
            real = real and (nodes[k].op != "add" or nodes[limit].op == "constant")
            if real and not any(step.graph.is_constant(limit, one) for one in (0.0, np.inf)):
                found.append(Compared(k, x, limit))
        elif nodes[k].op == "round":
            found += [Compared(k, nodes[k].args[0], half) for half in (-0.5, 0.5)]
    needed = {one.decision: step.needed.get(one.decision, NOTHING) for one in found}
    ends = {one.x for one in found} | {k for one in needed.values() for k, _ in one}
    before = reaches(step.graph, step.order, ends)
    early = {k for k in ends if late or before[k].bit_count() <= _EARLY}
    return [
        one._replace(needed=frozenset(two for two in needed[one.decision] if two[0] in early))
        for one in found
        if len(step.order) <= LONG or one.x in early
    ]


def _bases(
    step: Step, around: Around, compared: list[Compared], draw: np.random.Generator
) -> Bases:
    """Steps in which these decisions matter; where there is none, others."""
    chosen, steps = list[Compared](), list[Arrays]()
    long = len(step.order) > LONG
    share = _ALL // max(len(compared), 1)
    count, most = (_FEW, min(max(3, 2 * share), 8)) if long else (_POOL, max(_BASES, share))
    for turn in range(_POOLS):
        missing = [one for one in compared if one not in chosen]
        if not missing:
            break
        states, samples = around.drawn(draw, count)
        pool = [*states, *samples]
        given = by_node(step.program, states, samples)
        matters = _matters(step, given, [one.decision for one in missing])
        apart = _distances(step, given, missing, count)
        for one, row, distance in zip(missing, matters, apart, strict=True):
            at = draw.permutation(np.flatnonzero(row))
            nearest = _nearest(at, distance[at], (most + 1) // 2)
            at = np.unique(np.concatenate([nearest, at[: most - len(nearest)]]))
            if not len(at) and turn + 1 == _POOLS and not long:
                at = draw.integers(count, size=1)
                chosen.append(one._replace(needed=NOTHING))
                steps.append([x[at] for x in pool])
            elif len(at):
                chosen += [one] * len(at)
                steps.append([x[at] for x in pool])
    numbers = ComparedNumbers(step, chosen)
    return Bases(chosen, [np.concatenate(column) for column in zip(*steps, strict=True)], numbers)


def _nearest(at: np.ndarray, distance: np.ndarray, most: int) -> np.ndarray:
    """Those closest to the limit, from both sides in turn: one may be held back."""
    order = np.argsort(np.abs(distance), kind="stable")
    sides = [at[order[distance[order] > 0]], at[order[~(distance[order] > 0)]]]
    both = [one for pair in zip_longest(*sides) for one in pair if one is not None]
    return np.array(both[:most], int)


def _matters(step: Step, given: Given, decisions: list[int]) -> np.ndarray:
    """Whether each decision, taken otherwise, changes a result of each step."""
    turned = [Mutant(k, OTHERWISE) for k in decisions]
    return detected(step, turned, plain(step, given), 1.0)


def _distances(
    step: Step, given: Given, compared: list[Compared], count: int
) -> Iterator[np.ndarray]:
    """How far each number is above its limit, in each step; what is no number last."""
    ends = {k for one in compared for k in (one.x, one.limit) if isinstance(k, int)}
    values = step.part(step.graph.reached(ends), ends).values(given)
    for _, x, limit, _ in compared:
        with np.errstate(all="ignore"):
            apart = values[x] - (values[limit] if isinstance(limit, int) else limit)
        yield np.broadcast_to(np.nan_to_num(apart, nan=np.inf), count)
