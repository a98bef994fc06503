"""A step on many states in NumPy, where there is no compiler."""

from collections.abc import Callable, Collection, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from tuner.code.array_functions import Work, function_of, work_of
from tuner.code.evaluation import Given, Sums, Values
from tuner.code.graph import Graph
from tuner.code.mutants import Mutant, with_changes
from tuner.code.rounding_errors import Noise
from tuner.code.slopes import slopes


class _Values(Values):
    """Values by nodes."""

    def __init__(self, known: dict[int, np.ndarray]) -> None:
        self._known = known

    def __getitem__(self, k: int) -> np.ndarray:
        return self._known[k]

    def __iter__(self) -> Iterator[int]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)

    def of(self, which: np.ndarray) -> "_Values":
        """Those of some states."""
        items = self._known.items()
        return _Values({k: x[which] if len(x) == len(which) else x for k, x in items})


class InNumPy:
    """Some nodes of a step, each of which follows from those before it.

    Args:
        graph: of the nodes.
        order: which, in order.
        ends: those whose values are asked for.

    Attributes:
        inputs: those that are.
    """

    def __init__(self, graph: Graph, order: Sequence[int], ends: Collection[int]) -> None:
        self._graph, self._order, self._ends = graph, order, frozenset(ends)
        self._works = dict[frozenset[int], list[Work]]()
        self.inputs = [k for k in order if graph.nodes[k].op == "input"]

    def values(self, given: Given) -> Values:
        """The ends, from the inputs."""
        known: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k, node, function, _, done in self._work(self._ends):
                if function is None:
                    known[k] = given[k] if node.op == "input" else np.array([node.value])
                else:
                    known[k] = function(*[known[part] for part in node.args])
                for part in done:
                    del known[part]
        return _Values(known)

    def noisy(self, given: Given, noise: Noise, ends: Sequence[int]) -> dict[int, np.ndarray]:
        """Some with random rounding errors of every operation, ``(repeats, B)`` each."""
        width = max((len(given[k]) for k in self.inputs), default=1)
        work = self._work(frozenset(ends))
        row, begin = noise.row(width, sum(one.rounded for one in work))
        shape, places = (noise.repeats, width), iter(begin.tolist())
        known: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k, node, function, rounded, done in work:
                if function is None:
                    found = given[k] if node.op == "input" else np.array([node.value])
                else:
                    found = function(*[known[part] for part in node.args])
                if rounded:
                    at = next(places)
                    found = found * row[at : at + noise.repeats * width].reshape(shape)
                known[k] = found
                for part in done:
                    del known[part]
        return {k: np.broadcast_to(known[k], shape) for k in ends}

    def changed(
        self, known: Values, ends: Sequence[int], mutants: Sequence[Mutant], by: float
    ) -> list[np.ndarray]:
        """Some, ``(M, B)`` where a change of a constant by a factor moves them, or as they are."""
        lanes: dict[Mutant, list[int]] = {}
        for lane, one in enumerate(mutants):
            lanes.setdefault(one, []).append(lane)
        changed, count = {one.node for one in lanes}, len(mutants)
        found: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k, node, function, _, done in self._after(changed, frozenset(ends)):
                if function is None:
                    continue
                args = [found[part] if part in found else known[part] for part in node.args]
                if k in changed:
                    found[k] = with_changes(self._graph, k, function, args, lanes, count, by)
                else:
                    found[k] = function(*args)
                for part in done:
                    found.pop(part, None)
        return [found[k] if k in found else known[k] for k in ends]

    def slopes(self, known: Values, sums: Sums) -> np.ndarray:
        """Sums of squared moves of weighted sums of results, ``(M, B)``, to first order."""
        return slopes(self._graph.nodes, self._functions, self._order, known, sums)

    def _work(self, ends: frozenset[int]) -> list[Work]:
        if ends not in self._works:
            self._works[ends] = work_of(self._graph.nodes, self._functions, self._order, ends)
        return self._works[ends]

    def _after(self, changed: Collection[int], ends: frozenset[int]) -> Iterator[Work]:
        """Some nodes and those that depend on them, in order."""
        seen = set(changed)
        for one in self._work(ends):
            if one.k in seen or not seen.isdisjoint(one.node.args):
                seen.add(one.k)
                yield one

    @cached_property
    def _functions(self) -> dict[int, Callable[..., Any] | None]:
        nodes = self._graph.nodes
        return {k: function_of(nodes[k], nodes) for k in self._order}
