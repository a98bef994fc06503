"""Steps in which two numbers that are compared are almost equal.

A limit shows where it just acts, and a series where its argument is largest: pairs of states on the
two sides are brought close to it by bisection.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tuner.code.array_step import Step
from tuner.code.operations import COMPARE
from tuner.code.states import Around, Arrays, placed

_BESIDE = (-3e-2, -5e-4, 5e-4, 3e-2)
"""Distances from a limit, over the limit; one that is changed is passed by the inner ones."""
_POOL, _PAIRS, _HALVINGS, _BATCH = 256, 6, 26, 128


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Steps on the two sides of a goal, by their numbers in a pool.

    Attributes:
        nodes: the number that is compared and its limit, of each pair.
        goal: what the number is to be, over the limit.
        low, high: steps where it is less, and more.
    """

    nodes: list[tuple[int, int]]
    goal: np.ndarray
    low: np.ndarray
    high: np.ndarray


def beside_limits(
    step: Step, around: Around, draw: np.random.Generator
) -> Iterator[tuple[Arrays, Arrays]]:
    """States and samples, a field each, in batches.

    Args:
        step: the filter's.
        around: where states are drawn.
        draw: a generator.
    """
    states, samples = around.drawn(draw, _POOL)
    samples = [np.nan_to_num(x) if x.dtype.kind == "f" else x for x in samples]
    pairs = _pairs(step, states, samples, draw)
    if not len(pairs.goal):
        return
    near, with_them = _halved(step, states, samples, pairs)
    for at in range(0, len(pairs.goal), _BATCH):
        part = slice(at, at + _BATCH)
        yield [x[part] for x in near], [x[part] for x in with_them]


def _compared(step: Step) -> list[tuple[int, int]]:
    """Real numbers that are compared, the second no zero."""
    nodes, found = step.graph.nodes, set()
    for k in step.order:
        if nodes[k].op in COMPARE or nodes[k].op in ("max", "min"):
            x, limit = nodes[k].args
            if nodes[x].op == "constant":
                x, limit = limit, x
            real = nodes[x].kind == nodes[limit].kind == "real"
            if real and not step.graph.is_constant(limit, 0.0):
                found.add((x, limit))
    return sorted(found)


def _apart(
    step: Step, states: Arrays, samples: Arrays, nodes: list[tuple[int, int]], count: int
) -> np.ndarray:
    """Two numbers of each pair in every step, ``(pairs, 2, count)``."""
    watched = {k: np.zeros(1) for pair in nodes for k in pair}
    step.results(placed(step.program, states, samples), watched=watched)
    whole = {k: np.broadcast_to(np.asarray(x, float), count) for k, x in watched.items()}
    return np.array([[whole[k] for k in pair] for pair in nodes]).reshape(len(nodes), 2, count)


def _pairs(step: Step, states: Arrays, samples: Arrays, draw: np.random.Generator) -> _Pairs:
    nodes: list[tuple[int, int]] = []
    rows: list[tuple[float, int, int]] = []
    compared = _compared(step)
    for pair, (x, limit) in zip(
        compared, _apart(step, states, samples, compared, _POOL), strict=True
    ):
        for beside in _BESIDE:
            above = x - limit * (1 + beside)
            low, high = np.flatnonzero(above < 0), np.flatnonzero(above > 0)
            if len(low) and len(high):
                both = zip(draw.choice(low, _PAIRS), draw.choice(high, _PAIRS), strict=True)
                rows += [(1 + beside, int(a), int(b)) for a, b in both]
                nodes += [pair] * _PAIRS
    goal, low, high = np.array(rows).reshape(len(rows), 3).T
    return _Pairs(nodes, goal, low.astype(int), high.astype(int))


def _halved(step: Step, states: Arrays, samples: Arrays, pairs: _Pairs) -> tuple[Arrays, Arrays]:
    """Steps between the two sides, close to the goals."""
    count = len(pairs.goal)
    low, high, lanes = np.zeros(count), np.ones(count), np.arange(count)
    distinct = sorted(set(pairs.nodes))
    own = np.array([distinct.index(pair) for pair in pairs.nodes])

    def at(share: np.ndarray) -> tuple[Arrays, Arrays]:
        def between(part: Arrays) -> Arrays:
            return [_between(x[pairs.low], x[pairs.high], share) for x in part]

        return between(states), between(samples)

    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        both = _apart(step, *at(middle), distinct, count)
        with np.errstate(invalid="ignore"):
            below = both[own, 0, lanes] < pairs.goal * both[own, 1, lanes]
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return at(low)


def _between(one: np.ndarray, other: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Between two arrays; whole numbers and truth values are the first one's."""
    if one.dtype.kind != "f":
        return one
    axes = share[(slice(None),) + (None,) * (one.ndim - 1)]
    return np.asarray(one + axes * (other - one))
