"""One iteration of a time loop with its derivatives, as a graph of scalars."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tuner.code.graph import Graph
from tuner.code.interpreter import Arrays, objects
from tuner.code.operations import kind_of
from tuner.code.primitives import interpreter
from tuner.code.program import symmetric
from tuner.native.runner import Runner, is_real, with_slopes

MOST = 12_000
"""Most operations of an iteration, derivatives included, for C: more compile too long."""


class Pair(NamedTuple):
    """Nodes of a number and of its derivative; None where it has none."""

    value: int
    slope: int | None


class Cell(NamedTuple):
    """A number of the state: as an input, before the first sample, and after a sample."""

    input: Pair
    start: Pair
    after: Pair


@dataclass(frozen=True, eq=False)
class Iteration:
    """A traced iteration, with derivatives in one arbitrary direction.

    Attributes:
        graph: with inputs ``("p", k)`` for the k-th varying number of the parameters,
            ``("dp", k)`` for its derivative, ``("u", k)`` for a number of a sample, ``("s", k, i)``
            and ``("ds", k, i)`` for a number of the state and its derivative.
        cells: the state.
        total: the cells needed at the end, one for each number.
        kept: the values kept of a sample, one for each number.
    """

    graph: Graph
    cells: list[Cell]
    total: list[int]
    kept: list[Pair]


@dataclass(frozen=True, eq=False)
class _WithTangent:
    """Nodes of an array and of its derivative."""

    values: np.ndarray
    slopes: np.ndarray | None

    def pair(self, at: tuple[int, ...]) -> Pair:
        return Pair(self.values[at], None if self.slopes is None else self.slopes[at])


def iteration(runner: Runner) -> Iteration:
    """Trace a loop.

    Raises:
        NoCounterpartError: names the operation that has no counterpart among scalars.
        TooLargeError: for an iteration of more than :data:`MOST` operations.
    """
    begun = with_slopes(runner.start, [runner.params])
    stepped = with_slopes(runner.step, [runner.params, runner.state], [runner.sample])
    halves = {k for k, leaf in enumerate(runner.state) if _square(leaf)}
    while True:
        found, wrong = _attempt(runner, begun, stepped, halves)
        if not wrong:
            return found
        halves -= wrong


def _attempt(
    runner: Runner, begun: Any, stepped: Any, halves: set[int]
) -> tuple[Iteration, set[int]]:
    """The iteration if these matrices are symmetric, and which of them turn out not to be."""
    graph, size = Graph(most=MOST), len(runner.state)
    way = interpreter(graph)
    params = _parameters(graph, runner)
    slopes = [one.slopes for one in params if one.slopes is not None]
    values = [one.values for one in params]
    starts = _pairs(graph, way.closed(begun, [*values, *slopes]), begun, size)
    halves &= {k for k in halves if _symmetric(graph, starts[k])}
    before = [_inputs(graph, k, leaf, k in halves) for k, leaf in enumerate(runner.state)]
    changes = [one.slopes for one in before if one.slopes is not None]
    arguments = [*values, *(one.values for one in before), *slopes, *changes]
    found = way.closed(stepped, [*arguments, *_sample(graph, runner.sample)])
    after = _pairs(graph, found, stepped, size + len(runner.keeps))
    wrong = {k for k in halves if not _symmetric(graph, after[k])}
    cells, total = _cells(runner, halves, before, starts, after)
    kept = [one.pair(at) for one in after[size:] for at in np.ndindex(one.values.shape)]
    wanted = [k for one, k in zip(after[size:], runner.keeps, strict=True) for _ in one.values.flat]
    return Iteration(
        graph, cells, total, [x for x, k in zip(kept, wanted, strict=True) if k]
    ), wrong


def _cells(
    runner: Runner,
    halves: set[int],
    before: list[_WithTangent],
    starts: list[_WithTangent],
    after: list[_WithTangent],
) -> tuple[list[Cell], list[int]]:
    """The state, and which of its numbers are needed."""
    cells: list[Cell] = []
    total: list[int] = []
    for k, wanted in enumerate(runner.wanted):
        places: dict[tuple[int, ...], int] = {}
        for at in np.ndindex(before[k].values.shape):
            own = tuple(sorted(at)) if k in halves else at
            if own not in places:
                places[own] = len(cells)
                cells.append(Cell(before[k].pair(own), starts[k].pair(own), after[k].pair(own)))
            total += [places[own]] if wanted else []
    return cells, total


def _parameters(graph: Graph, runner: Runner) -> list[_WithTangent]:
    """Constants, and inputs for numbers that depend on a point."""
    found, count = [], 0
    for leaf, moved in zip(runner.params, runner.moved, strict=True):
        values, slopes = np.empty(leaf.shape, object), np.empty(leaf.shape, object)
        for at in np.ndindex(leaf.shape):
            if moved[at].any():
                values[at] = graph.input(("p", count), kind_of(leaf.dtype))
                slopes[at] = graph.input(("dp", count))
                count += 1
            else:
                values[at], slopes[at] = graph.constant(leaf[at]), graph.constant(0.0)
        found.append(_WithTangent(values, slopes if is_real(leaf) else None))
    return found


def _inputs(graph: Graph, k: int, leaf: np.ndarray, half: bool) -> _WithTangent:
    values, slopes = np.empty(leaf.shape, object), np.empty(leaf.shape, object)
    for at in np.ndindex(leaf.shape):
        own = tuple(sorted(at)) if half else at
        values[at] = graph.input(("s", k, *own), kind_of(leaf.dtype))
        slopes[at] = graph.input(("ds", k, *own))
    return _WithTangent(values, slopes if is_real(leaf) else None)


def _sample(graph: Graph, sample: Arrays) -> Iterator[np.ndarray]:
    count = 0
    for leaf in sample:
        out = np.empty(leaf.shape, object)
        for at in np.ndindex(leaf.shape):
            out[at] = graph.input(("u", count), kind_of(leaf.dtype))
            count += 1
        yield out


def _pairs(graph: Graph, found: Arrays, closed: Any, count: int) -> list[_WithTangent]:
    """Results with their derivatives."""
    nodes = objects(graph, found)
    slopes = iter(nodes[count:])
    real = [is_real(aval) for aval in closed.out_avals[:count]]
    return [_WithTangent(x, next(slopes) if r else None) for x, r in zip(nodes, real, strict=False)]


def _square(leaf: np.ndarray) -> bool:
    return leaf.ndim == 2 and leaf.shape[0] == leaf.shape[1] > 1 and is_real(leaf)


def _symmetric(graph: Graph, both: _WithTangent) -> bool:
    """Whether a matrix and its derivative are symmetric, but for rounding."""
    return all(symmetric(graph, x) for x in (both.values, both.slopes) if x is not None)
