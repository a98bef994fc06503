"""A filter's step in NumPy on many states at once, with a constant changed in each lane."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from tuner.code.graph import Graph
from tuner.code.nodes import Node
from tuner.code.on_arrays import function_of
from tuner.code.operations import LOGIC
from tuner.code.program import Program

CHANGE = 1e-3
"""A constant is changed by this share of itself."""
_EXACT = frozenset({"neg", "abs", "choose", "convert", "max", "min", *LOGIC})
_ABSORBING = frozenset({"choose", "max", "min", *LOGIC})
"""Operations that may give the same result of other operands."""
Given: TypeAlias = Mapping[int, np.ndarray]
"""Values of the input nodes, a state each: ``(B,)``."""


class Mutant(NamedTuple):
    """A constant, where one operation uses it.

    Attributes:
        node: the operation.
        at: which of its operands the constant is.
        limit: whether of a limit only the comparison with it is changed, which is a number of its
            own in C.
    """

    node: int
    at: int
    limit: bool = False


class Noise(NamedTuple):
    """Random errors of every operation.

    Attributes:
        draw: a generator.
        size: of an error, over the result.
        repeats: number of times that each step is worked out with errors of its own.
    """

    draw: np.random.Generator
    size: float
    repeats: int


@dataclass(frozen=True, eq=False)
class Step:
    """A step as an array calculation.

    Attributes:
        program: the filter.
    """

    program: Program

    @property
    def graph(self) -> Graph:
        """Of its scalars."""
        return self.program.graph

    @cached_property
    def roots(self) -> list[int]:
        """The stored entries of the next state, then those of the outputs."""
        program = self.program
        fields = [*program.state, *program.outputs]
        arrays = [*program.after, *program.out]
        pairs = zip(fields, arrays, strict=True)
        return [int(nodes[index]) for field, nodes in pairs for index in field.entries()]

    @cached_property
    def order(self) -> list[int]:
        """The nodes of a step."""
        return self.graph.reached(self.roots)

    @cached_property
    def _done(self) -> dict[int, list[int]]:
        """The nodes that are needed no longer after each one."""
        last = {part: k for k in self.order for part in self.graph.nodes[k].args}
        found: dict[int, list[int]] = {}
        for part, k in last.items():
            found.setdefault(k, []).append(part)
        return found

    @cached_property
    def mutants(self) -> list[Mutant]:
        """The constants of a step, but zeros and results that are constant."""
        return list(self._mutants())

    def _mutants(self) -> Iterator[Mutant]:
        nodes = self.graph.nodes
        for k in self.order:
            for at, part in enumerate(nodes[k].args):
                one = nodes[part]
                if one.op == "constant" and one.kind == "real" and _changes(one):
                    yield Mutant(k, at)
                    if nodes[k].op in ("max", "min"):
                        yield Mutant(k, at, limit=True)

    def results(self, given: Given, noise: Noise | None = None) -> list[np.ndarray]:
        """The roots, ``(B,)`` or ``(1,)`` each.

        Args:
            given: the inputs.
            noise: rounding errors of every operation; the roots are ``(repeats, B)`` then.
        """
        keep = set(self.roots)
        known: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k in self.order:
                known[k] = self._value(k, known, given)
                if noise is not None and k in self._rounded:
                    errors = noise.draw.uniform(-1, 1, (noise.repeats, known[k].shape[-1]))
                    known[k] = known[k] * (1 + noise.size * errors)
                for part in self._done.get(k, ()):
                    if part not in keep:
                        del known[part]
        return [known[k] for k in self.roots]

    def values(self, given: Given) -> dict[int, np.ndarray]:
        """All nodes of a step, ``(B,)`` or ``(1,)`` each."""
        known: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k in self.order:
                known[k] = self._value(k, known, given)
        return known

    def changed(
        self, known: Mapping[int, np.ndarray], mutants: list[Mutant], change: float = CHANGE
    ) -> dict[int, np.ndarray]:
        """The roots that changed constants move, by their places, ``(M, B)``.

        Only what follows from a constant is worked out, as far as the change goes: a comparison
        that comes out the same ends it.

        Args:
            known: all nodes of the step, by :meth:`values`.
            mutants: constants to be changed, one in each of M lanes.
            change: of a constant, as a share of itself.
        """
        lanes: dict[tuple[int, int, bool], list[int]] = {}
        for lane, one in enumerate(mutants):
            lanes.setdefault(one, []).append(lane)
        own, roots = {one[0] for one in lanes}, set(self.roots)
        nodes, moved = self.graph.nodes, dict[int, np.ndarray]()
        with np.errstate(all="ignore"):
            for k in self.order[min((self._places[k] for k in own), default=0) :]:
                args = nodes[k].args
                if k not in own and moved.keys().isdisjoint(args):
                    continue
                given = [moved.get(part, known[part]) for part in args]
                if k in own:
                    found = self._lanes(k, given, lanes, len(mutants), 1 + change)
                else:
                    found = self._call(k, given)
                for part in self._done.get(k, ()):
                    if part not in roots:
                        moved.pop(part, None)
                if nodes[k].op not in _ABSORBING or not np.all(found == known[k]):
                    moved[k] = found
        return {at: moved[k] for at, k in enumerate(self.roots) if k in moved}

    def _value(self, k: int, known: Mapping[int, np.ndarray], given: Given) -> np.ndarray:
        node = self.graph.nodes[k]
        if not node.args:
            return given[k] if node.op == "input" else np.array([node.value])
        return self._call(k, [known[part] for part in node.args])

    def _call(self, k: int, args: list[np.ndarray]) -> np.ndarray:
        function = self._functions[k]
        assert function is not None
        return np.asarray(function(*args))

    @cached_property
    def _places(self) -> dict[int, int]:
        """The place of each node in the order."""
        return {k: place for place, k in enumerate(self.order)}

    @cached_property
    def _functions(self) -> dict[int, Callable[..., Any] | None]:
        """What makes each node of its operands; None for inputs and constants."""
        return {k: function_of(self.graph.nodes[k], self.graph.nodes) for k in self.order}

    @cached_property
    def _rounded(self) -> set[int]:
        """The nodes that have a rounding error."""
        nodes = self.graph.nodes
        real = (k for k in self.order if nodes[k].kind == "real" and nodes[k].args)
        return {k for k in real if nodes[k].op not in _EXACT}

    def _lanes(
        self,
        k: int,
        args: list[np.ndarray],
        lanes: Mapping[tuple[int, int, bool], list[int]],
        M: int,
        by: float,
    ) -> np.ndarray:
        """A node with its constants changed in their lanes, ``(M, B)``."""
        node = self.graph.nodes[k]
        limit = None
        for at in range(len(args)):
            own = lanes.get((k, at, False), [])
            if own:
                args[at] = np.repeat(args[at][None], M, axis=0) * np.ones((M, 1))
                args[at][own] *= by
            if (k, at, True) in lanes:
                limit = at, lanes[k, at, True]
        found = self._call(k, args)
        if limit is not None:
            at, own = limit
            x, plain = args[1 - at], np.asarray(self.graph.nodes[node.args[at]].value)
            moved = plain * by
            full = np.array(
                np.broadcast_to(found, np.broadcast_shapes(found.shape, (M, 1), x.shape))
            )
            rows = np.broadcast_to(x, full.shape)[own]
            inside = rows <= moved if node.op == "max" else rows >= moved
            full[own] = np.where(inside, plain, rows)
            found = full
        return found


def _changes(node: Node) -> bool:
    return bool(np.isfinite(node.value)) and node.value != 0
