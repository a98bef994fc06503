"""A filter's step in NumPy on many states, with constants changed or with rounding errors."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from tuner.code.graph import Graph
from tuner.code.mutants import CHANGE, Mutant, limits_of, mutants_of, with_changes
from tuner.code.nodes import Node
from tuner.code.operations import BINARY, COMPARE, LOGIC, UNARY
from tuner.code.program import Program
from tuner.code.rounding_errors import Noise

_EXACT = frozenset({"neg", "abs", "choose", "convert", "max", "min", *LOGIC})
Given: TypeAlias = Mapping[int, np.ndarray]
"""Values of the input nodes, a state each: ``(B,)``."""


class _Work(NamedTuple):
    """A node of a step, and the nodes that are needed no longer after it."""

    k: int
    node: Node
    function: Callable[..., Any] | None
    rounded: bool
    done: list[int]


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
    def _order_of_work(self) -> list[_Work]:
        """Each node with what makes it, and with the nodes that are needed no longer after it."""
        last = {part: k for k in self.order for part in self.graph.nodes[k].args}
        done: dict[int, list[int]] = {}
        roots = set(self.roots)
        for part, k in last.items():
            if part not in roots:
                done.setdefault(k, []).append(part)
        nodes = self.graph.nodes
        return [
            _Work(k, nodes[k], self.functions[k], k in self._rounded, done.get(k, []))
            for k in self.order
        ]

    @cached_property
    def decisions(self) -> list[tuple[int, int]]:
        """The real numbers that are compared."""
        nodes = self.graph.nodes
        compared = {nodes[k].args for k in self.order if nodes[k].op in COMPARE}
        return [(x, y) for x, y in sorted(compared) if nodes[x].kind == nodes[y].kind == "real"]

    @cached_property
    def to_whole(self) -> list[int]:
        """The numbers that are rounded to whole ones."""
        return sorted(
            {
                x
                for k in self.order
                if self.graph.nodes[k].op == "round"
                for x in self.graph.nodes[k].args
            }
        )

    @cached_property
    def mutants(self) -> list[Mutant]:
        """The constants of a step."""
        return list(mutants_of(self.graph, self.order))

    @cached_property
    def limits(self) -> set[Mutant]:
        """Those that only decide between results."""
        return limits_of(self.graph, self.order, self.roots)

    def results(
        self,
        given: Given,
        mutants: list[Mutant] | None = None,
        noise: Noise | None = None,
        watched: dict[int, np.ndarray] | None = None,
        change: float = CHANGE,
    ) -> list[np.ndarray]:
        """The roots, ``(B,)`` or ``(1,)`` each; with mutants ``(M, B)`` where they make a change.

        Args:
            given: the inputs.
            mutants: constants to be changed, one in each of M lanes.
            noise: rounding errors of every operation; the roots are ``(repeats, B)`` then.
            watched: nodes whose values are filled in.
            change: of a constant, as a share of itself.
        """
        lanes: dict[Mutant, list[int]] = {}
        for lane, one in enumerate(mutants or ()):
            lanes.setdefault(one, []).append(lane)
        changed, count = {one.node for one in lanes}, len(mutants or ())
        width = max(map(len, given.values()), default=1)
        errors = None if noise is None else noise.errors(width)
        known: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k, node, function, rounded, done in self._order_of_work:
                if function is None:
                    found = given[k] if node.op == "input" else np.array([node.value])
                else:
                    args = [known[part] for part in node.args]
                    if k in changed:
                        by = 1 + change
                        found = with_changes(self.graph, k, function, args, lanes, count, by)
                    else:
                        found = function(*args)
                if errors is not None and rounded:
                    found = found * next(errors)
                known[k] = found
                if watched is not None and k in watched:
                    watched[k] = found
                for part in done:
                    del known[part]
        return [known[k] for k in self.roots]

    def values(self, given: Given, nodes: Sequence[int]) -> dict[int, np.ndarray]:
        """Nodes, ``(B,)`` or ``(1,)`` each: in order, and none without what it is made of."""
        known: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k in nodes:
                node, function = self.graph.nodes[k], self.functions[k]
                if function is None:
                    known[k] = given[k] if node.op == "input" else np.array([node.value])
                else:
                    known[k] = np.asarray(function(*(known[part] for part in node.args)))
        return known

    @cached_property
    def functions(self) -> dict[int, Callable[..., Any] | None]:
        """The function that makes each node of its operands; None for inputs and constants."""
        return {k: _function(self.graph.nodes[k], self.graph.nodes) for k in self.order}

    @cached_property
    def _rounded(self) -> set[int]:
        """The nodes that have a rounding error."""
        nodes = self.graph.nodes
        real = (k for k in self.order if nodes[k].kind == "real" and nodes[k].args)
        return {k for k in real if nodes[k].op not in _EXACT}


def _function(node: Node, nodes: list[Node]) -> Callable[..., Any] | None:
    """The function of arrays that an operation is."""
    if node.op in ("input", "constant"):
        return None
    if node.op == "choose":
        return np.where
    if node.op == "convert":
        if node.kind == "whole" and nodes[node.args[0]].kind == "real":
            return _whole
        kind = {"real": float, "whole": int, "truth": bool}[node.kind]
        return lambda x: np.asarray(x, kind)
    if node.kind == "whole" and node.op == "div":
        return lambda x, y: np.nan_to_num(np.trunc(x / y)).astype(int)
    return (UNARY if len(node.args) == 1 else BINARY)[node.op]


def _whole(x: np.ndarray) -> np.ndarray:
    """Real numbers made whole, as in C."""
    whole = np.nan_to_num(np.trunc(x), posinf=2**31 - 1, neginf=-(2**31))
    return np.asarray(np.clip(whole, -(2**31), 2**31 - 1).astype(int))
