"""The numbers that are compared, each pair in steps of its own.

A comparison depends on a part of a step, often a small one: only that is worked out in its steps.
"""

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property, reduce
from operator import or_
from typing import NamedTuple

import numpy as np

from tuner.code.array_step import Step
from tuner.code.decided import NOTHING, Decided
from tuner.code.evaluation import Evaluation, Given, Values
from tuner.code.graph import Graph

_OVERHEAD, _EACH = 300, 24
"""Steps in which to work out a node takes twice as long as in one, and the steps of a pair."""


class Compared(NamedTuple):
    """A comparison.

    Attributes:
        decision: its node.
        x: the number that is compared.
        limit: that with which it is: a node, or a number, as a half for rounding.
        needed: what else has to be decided, and how, for its outcome to matter.
    """

    decision: int
    x: int
    limit: int | float
    needed: Decided = NOTHING


class ComparedNumbers:
    """The numbers that are compared in a step.

    Args:
        step: the filter's.
        pairs: that are asked for, some of them often.
    """

    def __init__(self, step: Step, pairs: Sequence[Compared]) -> None:
        before = reaches(step.graph, step.order, {k for one in pairs for k in _nodes(one)})
        bits = [reduce(or_, (before[k] for k in _nodes(one))) for one in pairs]
        groups = _grouped(bits)
        self._parts = [_Part(step, one, before.keys()) for one in groups]
        which = {one: at for at, group in enumerate(groups) for one in bits if one | group == group}
        self._part_of = {pair: which[one] for pair, one in zip(pairs, bits, strict=True)}

    def in_own_steps(self, given: Given, pairs: Sequence[Compared]) -> np.ndarray:
        """Both numbers of each pair, and whether all that it needs is decided so, ``(3, B)``.

        Of each pair in as many steps, one after another.
        """
        count = max(map(len, given.values()), default=1)
        each, own = count // len(pairs), dict[int, list[int]]()
        for at, pair in enumerate(pairs):
            own.setdefault(self._part_of[pair], []).append(at)
        found = np.ones((3, len(pairs), each))
        for part, where in own.items():
            rows = (np.array(where)[:, None] * each + np.arange(each)).ravel()
            values = self._parts[part].values(given, rows)
            for k, at in enumerate(where):
                pair, own_rows = pairs[at], slice(k * each, (k + 1) * each)
                for side, one in enumerate((pair.x, pair.limit)):
                    found[side, at] = _some(values[one], own_rows) if isinstance(one, int) else one
            found[2, where] = _met(values, [pairs[at].needed for at in where], each)
        return found.reshape(3, count)


class _Part:
    """The nodes of a step, given as bits, that some pairs depend on."""

    def __init__(self, step: Step, bits: int, ends: Collection[int]) -> None:
        self._step, self._bits = step, bits
        self._ends = [k for k in ends if bits >> k & 1]

    @cached_property
    def _nodes(self) -> Evaluation:
        return self._step.part(set_bits(self._bits), self._ends)

    def values(self, given: Given, rows: np.ndarray) -> Values:
        """The ends in some of the steps."""
        return self._nodes.values({k: given[k][rows] for k in self._nodes.inputs})


def _grouped(bits: Sequence[int]) -> list[int]:
    """What pairs depend on, together where that takes less time than one after another."""
    counts = {one: bits.count(one) for one in sorted(set(bits))}
    groups: list[tuple[int, int]] = []
    for one in counts.items():
        if groups:
            both = groups[-1][0] | one[0], groups[-1][1] + one[1]
            if _cost(*both) <= _cost(*groups[-1]) + _cost(*one):
                groups[-1] = both
                continue
        groups.append(one)
    return [group for group, _ in groups]


def _cost(bits: int, pairs: int) -> int:
    return bits.bit_count() * (_OVERHEAD + _EACH * pairs)


def reaches(graph: Graph, order: Sequence[int], wanted: Collection[int]) -> dict[int, int]:
    """The nodes that some depend on, themselves included, as the set bits of a number each.

    Args:
        graph: of the nodes.
        order: these and all before them, in order.
        wanted: of which it is told.
    """
    nodes, last = graph.nodes, {part: k for k in order for part in graph.nodes[k].args}
    found = dict[int, int]()
    for k in order:
        args = set(nodes[k].args)
        found[k] = reduce(or_, (found[part] for part in args), 1 << k)
        for part in args:
            if last[part] == k and part not in wanted:
                del found[part]
    return {k: found[k] for k in wanted}


def set_bits(number: int) -> list[int]:
    """The places of the bits of a number that are set.

    >>> set_bits(0b1101)
    [0, 2, 3]
    """
    digits = np.frombuffer(number.to_bytes(number.bit_length() // 8 + 1, "little"), np.uint8)
    places: list[int] = np.flatnonzero(np.unpackbits(digits, bitorder="little")).tolist()
    return places


def _met(values: Values, needs: Sequence[Decided], each: int) -> np.ndarray:
    """Whether all is decided as each of some needs it, ``(needs, each)``, in its own steps."""
    needing = dict[tuple[int, bool], list[int]]()
    for k, needed in enumerate(needs):
        for one in needed:
            needing.setdefault(one, []).append(k)
    found = np.ones((len(needs), each), bool)
    for (node, truth), which in needing.items():
        row = np.broadcast_to(values[node], found.size).reshape(found.shape)
        found[which] &= row[which] == truth
    return found


def _some(row: np.ndarray, which: slice) -> np.ndarray:
    return row if len(row) == 1 else row[which]


def _nodes(pair: Compared) -> Iterator[int]:
    yield pair.x
    if isinstance(pair.limit, int):
        yield pair.limit
    yield from (k for k, _ in pair.needed)
