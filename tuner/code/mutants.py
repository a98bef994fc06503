"""A filter's step in NumPy on many states at once, with a constant changed in each lane."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from tuner.code.graph import Graph
from tuner.code.nodes import Node
from tuner.code.operations import LOGIC, in_numpy
from tuner.code.program import Program

CHANGE = 1e-3
"""A constant is changed by this share of itself."""
_EXACT = frozenset({"neg", "abs", "choose", "convert", "max", "min", *LOGIC})
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

    def results(
        self,
        given: Given,
        mutants: list[Mutant] | None = None,
        noise: tuple[np.random.Generator, float] | None = None,
        watched: dict[int, np.ndarray] | None = None,
        change: float = CHANGE,
    ) -> list[np.ndarray]:
        """The roots, ``(B,)`` or ``(1,)`` each; with mutants ``(M, B)`` where they make a change.

        Args:
            given: the inputs.
            mutants: constants to be changed, one in each of M lanes.
            noise: a generator, and the relative size of random errors of every operation.
            watched: nodes whose values are filled in.
            change: of a constant, as a share of itself.
        """
        nodes, keep = self.graph.nodes, set(self.roots)
        lanes: dict[tuple[int, int, bool], list[int]] = {}
        for lane, one in enumerate(mutants or ()):
            lanes.setdefault(one, []).append(lane)
        count, changed = len(mutants or ()), {one[0] for one in lanes}
        known: dict[int, np.ndarray] = {}
        for k in self.order:
            node = nodes[k]
            args = [known[part] for part in node.args]
            if node.op == "input":
                known[k] = given[k]
            elif node.op == "constant":
                known[k] = np.array([node.value])
            elif k in changed:
                known[k] = self._changed(k, args, lanes, count, 1 + change)
            else:
                known[k] = _worked_out(node, args, nodes)
            if noise is not None and node.kind == "real" and node.args and node.op not in _EXACT:
                draw, size = noise
                known[k] = known[k] * (1 + size * draw.uniform(-1, 1, known[k].shape))
            if watched is not None and k in watched:
                watched[k] = known[k]
            for part in self._done.get(k, ()):
                if part not in keep:
                    del known[part]
        return [known[k] for k in self.roots]

    def _changed(
        self,
        k: int,
        args: list[np.ndarray],
        lanes: Mapping[tuple[int, int, bool], list[int]],
        M: int,
        by: float,
    ) -> np.ndarray:
        node = self.graph.nodes[k]
        args = list(args)
        limit = None
        for at in range(len(args)):
            own = lanes.get((k, at, False), [])
            if own:
                args[at] = np.repeat(args[at][None], M, axis=0) * np.ones((M, 1))
                with np.errstate(over="ignore"):
                    args[at][own] *= by
            if (k, at, True) in lanes:
                limit = at, lanes[k, at, True]
        found = _worked_out(node, args, self.graph.nodes)
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


def _worked_out(node: Node, args: list[np.ndarray], nodes: list[Node]) -> np.ndarray:
    with np.errstate(all="ignore"):
        if node.op == "choose":
            return np.where(*args)
        if node.op == "convert":
            if node.kind == "whole" and nodes[node.args[0]].kind == "real":
                whole = np.nan_to_num(np.trunc(args[0]), posinf=2**31 - 1, neginf=-(2**31))
                return np.asarray(np.clip(whole, -(2**31), 2**31 - 1).astype(int))
            return np.asarray(args[0], {"real": float, "whole": int, "truth": bool}[node.kind])
        found = in_numpy(node.op, *args)
        if node.kind == "whole" and node.op == "div":
            found = np.nan_to_num(np.trunc(found)).astype(int)
        return np.asarray(found)
