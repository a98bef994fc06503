"""A filter's step in NumPy on many states, with constants changed or with rounding errors."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from tuner.code.array_functions import Work, function_of, work_of
from tuner.code.graph import Graph
from tuner.code.mutants import CHANGE, Mutant, limits_of, mutants_of, with_changes
from tuner.code.operations import COMPARE, STEPPED
from tuner.code.program import Program
from tuner.code.rounding_errors import Noise

Given: TypeAlias = Mapping[int, np.ndarray]
"""Values of the input nodes, a state each: ``(B,)``."""


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

    def work(self, order: Sequence[int], ends: Collection[int]) -> list[Work]:
        """Nodes in an order in which they can be made, of which only some are needed in the end."""
        return work_of(self.graph.nodes, self.functions, order, ends)

    @cached_property
    def _whole(self) -> list[Work]:
        return self.work(self.order, set(self.roots))

    @cached_property
    def _kept(self) -> list[Work]:
        return self.work(self.order, set(self.order))

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

    @cached_property
    def own_limits(self) -> set[Mutant]:
        """Those of the latter that a number is compared with themselves."""
        nodes = self.graph.nodes
        return {one for one in self.limits if one.limit or nodes[one.node].op in STEPPED}

    def values(self, given: Given, work: Sequence[Work]) -> dict[int, np.ndarray]:
        """The nodes that some work leaves in the end, ``(B,)`` or ``(1,)`` each."""
        known: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k, node, function, _, done in work:
                if function is None:
                    known[k] = given[k] if node.op == "input" else np.array([node.value])
                else:
                    known[k] = function(*[known[part] for part in node.args])
                for part in done:
                    del known[part]
        return known

    def all_values(self, given: Given) -> dict[int, np.ndarray]:
        """All nodes of the step, ``(B,)`` or ``(1,)`` each."""
        return self.values(given, self._kept)

    def results(
        self,
        known: Mapping[int, np.ndarray],
        mutants: Sequence[Mutant] = (),
        change: float = CHANGE,
    ) -> list[np.ndarray]:
        """The roots, ``(B,)`` or ``(1,)`` each, or ``(M, B)`` where mutants make a change.

        Args:
            known: all nodes as they are without a change.
            mutants: constants to be changed, one in each of M lanes.
            change: of a constant, as a share of itself.
        """
        lanes: dict[Mutant, list[int]] = {}
        for lane, one in enumerate(mutants):
            lanes.setdefault(one, []).append(lane)
        changed, count = {one.node for one in lanes}, len(mutants)
        found: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k, node, function, _, done in self._after(changed):
                if function is None:
                    continue
                args = [found[part] if part in found else known[part] for part in node.args]
                if k in changed:
                    by = 1 + change
                    found[k] = with_changes(self.graph, k, function, args, lanes, count, by)
                else:
                    found[k] = function(*args)
                for part in done:
                    found.pop(part, None)
        return [found[k] if k in found else known[k] for k in self.roots]

    def _after(self, changed: Collection[int]) -> Iterator[Work]:
        """Some nodes and those that depend on them, in order."""
        return map(self._work_of.__getitem__, sorted(self.after(changed)))

    def after(self, changed: Collection[int]) -> set[int]:
        """Some nodes and those that depend on them."""
        seen, open_ = set(changed), list(changed)
        while open_:
            more = [k for k in self._users.get(open_.pop(), ()) if k not in seen]
            seen.update(more)
            open_ += more
        return seen

    @cached_property
    def _work_of(self) -> dict[int, Work]:
        return {one.k: one for one in self._whole}

    @cached_property
    def _users(self) -> dict[int, list[int]]:
        found: dict[int, list[int]] = {}
        for one in self._whole:
            for part in one.node.args:
                found.setdefault(part, []).append(one.k)
        return found

    def noisy_results(
        self, given: Given, noise: Noise, watched: dict[int, np.ndarray]
    ) -> list[np.ndarray]:
        """The roots with random rounding errors of every operation, ``(repeats, B)`` each.

        Args:
            given: the inputs.
            noise: the errors.
            watched: nodes whose values are filled in.
        """
        errors = noise.errors(max(map(len, given.values()), default=1))
        known: dict[int, np.ndarray] = {}
        with np.errstate(all="ignore"):
            for k, node, function, rounded, done in self._whole:
                if function is None:
                    found = given[k] if node.op == "input" else np.array([node.value])
                else:
                    found = function(*[known[part] for part in node.args])
                known[k] = found * next(errors) if rounded else found
                if k in watched:
                    watched[k] = known[k]
                for part in done:
                    del known[part]
        return [known[k] for k in self.roots]

    @cached_property
    def functions(self) -> dict[int, Callable[..., Any] | None]:
        """The function that makes each node of its operands; None for inputs and constants."""
        return {k: function_of(self.graph.nodes[k], self.graph.nodes) for k in self.order}
