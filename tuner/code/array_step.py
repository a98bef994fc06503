"""A filter's step on many states at once, with constants changed or with rounding errors."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tuner.code.by_compiler import Compiled
from tuner.code.by_numpy import InNumPy
from tuner.code.calculator import calculator
from tuner.code.decided import Decided
from tuner.code.evaluation import Evaluation, Given, Values
from tuner.code.graph import Graph
from tuner.code.mutants import CHANGE, Mutant, limits_of, mutants_of
from tuner.code.needed import Ways
from tuner.code.operations import COMPARE, STEPPED
from tuner.code.program import Program


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

    def part(self, order: Sequence[int], ends: Collection[int]) -> Evaluation:
        """Some nodes, each of which follows from those before it, of which the ends are wanted."""
        code = calculator()
        if code is None:
            return InNumPy(self.graph, order, ends)
        return Compiled(code, self.graph.nodes, order, ends)

    @cached_property
    def whole(self) -> Evaluation:
        """All nodes."""
        return self.part(self.order, self.order)

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

    @cached_property
    def ways(self) -> Ways:
        """From constants to the results."""
        return Ways(self.graph, self.order, self.roots)

    @cached_property
    def needed(self) -> dict[int, Decided]:
        """What has to be decided for each operation to matter."""
        return self.ways.for_each(self.order)

    def all_values(self, given: Given) -> Values:
        """All nodes of the step, ``(B,)`` or ``(1,)`` each."""
        return self.whole.values(given)

    def results(
        self, known: Values, mutants: Sequence[Mutant] = (), change: float = CHANGE
    ) -> list[np.ndarray]:
        """The roots, ``(B,)`` or ``(1,)`` each, or ``(M, B)`` where mutants make a change.

        Args:
            known: all nodes as they are without a change.
            mutants: constants to be changed, one in each of M lanes.
            change: of a constant, as a share of itself.
        """
        return self.whole.changed(known, self.roots, mutants, 1 + change)

    def after(self, changed: Collection[int]) -> set[int]:
        """Some nodes and those that depend on them."""
        seen, open_ = set(changed), list(changed)
        while open_:
            more = [k for k in self._users.get(open_.pop(), ()) if k not in seen]
            seen.update(more)
            open_ += more
        return seen

    @cached_property
    def _users(self) -> dict[int, list[int]]:
        found: dict[int, list[int]] = {}
        for k in self.order:
            for part in self.graph.nodes[k].args:
                found.setdefault(part, []).append(k)
        return found
