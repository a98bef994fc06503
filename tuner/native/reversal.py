"""One iteration of a time loop and its way back, as a graph of scalars.

The way back is JAX's own, with the covariance's steps by hand (:mod:`filters.way_back`): a function
from the derivatives of a score by all that a sample leaves behind to those by what it began with.
"""

import itertools
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.invariant import split
from filters.way_back import STEPS
from objectives.in_numpy import in_numpy
from tuner.code.graph import Graph
from tuner.code.interpreter import Arrays, objects
from tuner.code.operations import kind_of
from tuner.code.primitives import interpreter
from tuner.code.program import symmetric
from tuner.native.active import moved
from tuner.native.runner import Runner, is_real

MOST_TRACED = 60_000
"""Most operations of a traced iteration with its way back, of which many may turn out constant."""


class Ends(NamedTuple):
    """Nodes of a number of the state, and of the score's derivatives by it.

    Attributes:
        input: the number before a sample.
        start: before the first one.
        after: after a sample.
        weight: the derivative by the number after a sample; None where it has none.
        slope: the derivative by the number before it.
    """

    input: int
    start: int
    after: int
    weight: int | None
    slope: int | None


@dataclass(frozen=True, eq=False)
class Reversal:
    """A traced iteration with its way back.

    Attributes:
        graph: with inputs ``("p", k)`` for the k-th varying number, ``("u", k)`` for a number of a
            sample, ``("s", k, i)`` for a number of the state, ``("w", k, i)`` for the derivative
            by it after a sample, and ``("v", k)`` by the k-th kept number.
        cells: the state.
        total: the cells needed at the end, one for each number.
        kept: the values kept of a sample, with whether they have derivatives.
        slopes: for each varying number of the parameters, the derivative by it in a sample; None
            where it has none.
        begun: for each varying number of the start, the cell that it is the start of.
    """

    graph: Graph
    cells: list[Ends]
    total: list[int]
    kept: list[tuple[int, bool]]
    slopes: list[int | None]
    begun: list[int]


class Before:
    """All that follows from a point before the first sample.

    Args:
        runner: the loop.
        build: the map from a point to the filter's parameters.
        size: of a point.

    Attributes:
        rest: the step from there on.
        fixed: what follows from the parameters, at an arbitrary point.
        elsewhere: the same at another point.
        start: the state before the first sample, at the first of these points.
        even: which arrays of the start are symmetric matrices.
        places: for each array of both, which of the varying numbers its entries are; -1: none.
        diagonal: which arrays of both are square matrices that vary on their diagonals alone.
        count: of the varying numbers.
    """

    def __init__(self, runner: Runner, build: Callable[[Array], Any], size: int) -> None:
        def step(params: Any, state: Any, sample: Any) -> tuple[Any, Any]:
            return runner.step(params, state, sample), ()

        before, self.rest = split(step, runner.params, runner.state, runner.sample, STEPS)

        def known(z: Array) -> tuple[list[Any], list[Any]]:
            params = jax.tree.leaves(build(z))
            return before(params), list(runner.start(params))

        self._known = known
        self.fixed, self.start = _arrays(in_numpy(known, np.zeros(size)))
        point = np.random.default_rng(0).normal(size=size)
        self.elsewhere, started = _arrays(in_numpy(known, point))
        self.even = [_even(a) and _even(b) for a, b in zip(self.start, started, strict=True)]
        varying = [np.asarray(leaf.any(-1)) for leaf in moved(known, size)]
        self.diagonal = [_on_diagonal(leaf) for leaf in varying]
        self._number(varying)

    def _number(self, varying: list[np.ndarray]) -> None:
        self.places, self.count = [], 0
        for moves in varying:
            place = np.full(moves.shape, -1)
            place[moves] = np.arange(self.count, self.count + moves.sum())
            self.places.append(place)
            self.count += int(moves.sum())

    def by_arrays(self) -> "Before":
        """The same, where an array with a varying number varies as a whole, and the start does."""
        other, fixed = copy(self), len(self.fixed)
        whole: list[np.ndarray] = []
        for k, place in enumerate(self.places):
            whole.append(np.full(place.shape, k >= fixed or (place >= 0).any()))
        other._number(whole)
        return other

    def numbers(self, z: Array) -> Array:
        """The numbers that vary with a point: of the parameters, then of the start."""
        pairs = zip(jax.tree.leaves(self._known(z)), self.places, strict=True)
        parts = [jnp.ravel(leaf)[place.ravel() >= 0] for leaf, place in pairs]
        return jnp.concatenate([part.astype(float) for part in parts])


def _on_diagonal(varying: np.ndarray) -> bool:
    square = varying.ndim == 2 and len(set(varying.shape)) == 1
    return square and not (varying & ~np.eye(len(varying), dtype=bool)).any()


def reversal(runner: Runner, before: Before, most: int = MOST_TRACED) -> Reversal:
    """Trace a loop with its way back.

    Args:
        runner: the loop.
        before: what precedes it.
        most: limit of operations, constant ones included.

    Raises:
        NoCounterpartError: names the operation that has no counterpart among scalars.
        TooLargeError: for an iteration of more operations.
    """
    halves = {k for k, even in enumerate(before.even) if even and not runner.wanted[k]}
    closed = traced(runner, before)
    while True:
        found, wrong = _attempt(runner, before, closed, halves, most)
        if not wrong:
            return found
        halves -= wrong


def traced(runner: Runner, before: Before) -> Any:
    """A step and its way back: its results, then the derivatives by parameters and state."""

    def both(fixed: list[Any], state: list[Any], sample: list[Any], weights: list[Any]) -> Any:
        def of_real(real: list[Any], moving: list[Any]) -> Any:
            found, _ = before.rest(_filled(fixed, real), _filled(state, moving), sample)
            return _real(found), found

        _, pull, found = jax.vjp(of_real, _real(fixed), _real(state), has_aux=True)
        return found, *pull(weights)

    found = jax.eval_shape(runner.step, runner.params, runner.state, runner.sample)
    weights = [np.zeros(leaf.shape) for leaf in _real(found)]
    return jax.make_jaxpr(both)(before.fixed, before.start, list(runner.sample), weights)


def _attempt(
    runner: Runner, before: Before, closed: Any, halves: set[int], most: int
) -> tuple[Reversal, set[int]]:
    """The iteration if these matrices are symmetric, and which of them turn out not to be."""
    graph, size, count = Graph(most=most), len(before.fixed), len(before.start)
    numbers = [
        _numbers(graph, leaf, place)
        for leaf, place in zip([*before.fixed, *before.start], before.places, strict=True)
    ]
    fixed, starts = numbers[:size], objects(graph, numbers[size:])
    state = [_inputs(graph, ("s", k), x, k in halves) for k, x in enumerate(before.start)]
    weights = [_inputs(graph, ("w", k), x, k in halves) for k, x in enumerate(before.start)]
    kept_shapes = closed.out_avals[count : count + len(runner.keeps)]
    kept_weights = _of_kept(graph, kept_shapes, runner.keeps)
    shapes = [*before.start, *kept_shapes]
    pairs = zip([*weights, *kept_weights], shapes, strict=True)
    given = [nodes for nodes, leaf in pairs if is_real(leaf)]
    arguments = [*fixed, *state, *_sample(graph, runner.sample), *given]
    found = objects(graph, interpreter(graph).closed(closed, arguments))
    results, back = found[: len(shapes)], iter(found[len(shapes) :])
    by_fixed = [next(back) if is_real(leaf) else None for leaf in before.fixed]
    by_state = [next(back) if is_real(leaf) else None for leaf in before.start]
    wrong = {k for k in halves if not symmetric(graph, results[k])}
    cells: list[Ends] = []
    total: list[int] = []
    begun: dict[int, int] = {}
    for k, leaf in enumerate(before.start):
        own: dict[tuple[int, ...], int] = {}
        for at in np.ndindex(leaf.shape):
            half = tuple(sorted(at)) if k in halves else at
            if half not in own:
                own[half] = len(cells)
                slope = _slope(graph, by_state[k], half, k in halves)
                weight = None if slope is None else weights[k][half]
                nodes = state[k][half], starts[k][half], results[k][half], weight, slope
                cells.append(Ends(*nodes))
            begun[int(before.places[size + k][at])] = own[half]
            total += [own[half]] if runner.wanted[k] else []
    kept = [
        (int(nodes[at]), is_real(leaf))
        for nodes, leaf, wanted in zip(results[count:], kept_shapes, runner.keeps, strict=True)
        for at in np.ndindex(leaf.shape)
        if wanted
    ]
    slopes = [
        None if by is None else by[tuple(at)]
        for by, place in zip(by_fixed, before.places, strict=False)
        for at in np.argwhere(place >= 0)
    ]
    whole = sum(int((place >= 0).sum()) for place in before.places)
    first = [begun[k] for k in range(len(slopes), whole)]
    return Reversal(graph, cells, total, kept, slopes, first), wrong


def _slope(graph: Graph, by: np.ndarray | None, at: tuple[int, ...], half: bool) -> int | None:
    """The derivative by a number; by one of two mirrored ones, half of both."""
    if by is None:
        return None
    one, other = by[at], by[at[::-1]] if half else by[at]
    if graph.points.same(one, other):
        return int(one)
    return graph.apply("mul", graph.constant(0.5), graph.apply("add", one, other))


def _numbers(graph: Graph, leaf: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Constants, and inputs for numbers that vary with a point; what varies nowhere stays known."""
    if (place < 0).all():
        return leaf
    out, kind = np.empty(leaf.shape, object), kind_of(leaf.dtype)
    for at in np.ndindex(leaf.shape):
        k = int(place[at])
        out[at] = graph.constant(leaf[at]) if k < 0 else graph.input(("p", k), kind)
    return out


def _inputs(graph: Graph, group: tuple[Any, ...], leaf: Any, half: bool) -> np.ndarray:
    out, kind = np.empty(leaf.shape, object), kind_of(leaf.dtype)
    for at in np.ndindex(leaf.shape):
        own = tuple(sorted(at)) if half else at
        out[at] = graph.input((*group, *own), kind)
    return out


def _sample(graph: Graph, sample: Arrays) -> Iterator[np.ndarray]:
    count = itertools.count()
    for leaf in sample:
        out = np.empty(leaf.shape, object)
        for at in np.ndindex(leaf.shape):
            out[at] = graph.input(("u", next(count)), kind_of(leaf.dtype))
        yield out


def _of_kept(graph: Graph, shapes: Sequence[Any], keeps: Sequence[bool]) -> Iterator[np.ndarray]:
    """Derivatives by the kept numbers; zeros for those that are not needed."""
    count = itertools.count()
    for leaf, wanted in zip(shapes, keeps, strict=True):
        out = np.empty(leaf.shape, object)
        for at in np.ndindex(leaf.shape):
            real = wanted and is_real(leaf)
            out[at] = graph.input(("v", next(count))) if real else graph.constant(0.0)
        yield out


def _real(leaves: Sequence[Any]) -> list[Any]:
    return [leaf for leaf in leaves if is_real(leaf)]


def _filled(leaves: Sequence[Any], real: Sequence[Any]) -> list[Any]:
    """Leaves, with others in the place of those that are real."""
    rest = iter(real)
    return [next(rest) if is_real(leaf) else leaf for leaf in leaves]


def _arrays(both: Any) -> tuple[Arrays, Arrays]:
    one, other = both
    return [np.asarray(x) for x in one], [np.asarray(x) for x in other]


def _even(leaf: np.ndarray) -> bool:
    """Whether an array is a symmetric matrix, but for rounding."""
    square = leaf.ndim == 2 and leaf.shape[0] == leaf.shape[1] > 1 and is_real(leaf)
    return square and bool(np.allclose(leaf, leaf.T, rtol=1e-12, atol=0, equal_nan=True))
