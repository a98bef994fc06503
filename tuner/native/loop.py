"""A time loop with derivatives in several directions, without constant entries."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from tuner.code.graph import Graph
from tuner.native.iteration import MOST, Iteration, Pair
from tuner.native.rewriting import Rewriter

Key: TypeAlias = tuple[int, int]
"""A number of the state: its cell, and 0 for its value or from 1 on for its derivatives."""


class Carried(NamedTuple):
    """Nodes of a carried number: before a sample, at the start, after a sample."""

    input: int
    start: int
    after: int


@dataclass(frozen=True, eq=False)
class Loop:
    """A time loop.

    Attributes:
        graph: of the nodes. Inputs are those of an iteration; derivatives have a direction too.
        carried: numbers carried over time.
        total: for each number needed at the end, nodes of its value and derivatives,
            which are read after the last sample.
        kept: the same for each number that is kept of a sample.
        directions: number of derivatives of each number.
    """

    graph: Graph
    carried: list[Carried]
    total: list[list[int]]
    kept: list[list[int]]
    directions: int

    @property
    def needed(self) -> list[int]:
        """The operations of an iteration."""
        roots = [cell.after for cell in self.carried] + [k for row in self.kept for k in row]
        return [k for k in self.graph.reached(roots) if self.graph.nodes[k].args]

    @property
    def operations(self) -> int:
        """Number of operations in an iteration."""
        return len(self.needed)


def loop(iteration: Iteration, moves: Sequence[np.ndarray]) -> Loop:
    """The loop of an iteration, with derivatives in several directions.

    What is a number at the start and the same number after a sample is one for good; most of these
    are zeros, and what they are multiplied with goes with them.

    Args:
        iteration: the iteration.
        moves: for each direction, which of the varying parameters vary in it.

    Raises:
        TooLargeError: for more operations than :data:`tuner.native.iteration.MOST`.
    """
    assumed: set[Key] | None = None
    while True:
        attempt = _Attempt(iteration, moves, assumed)
        still = {key for key, cell in attempt.cells.items() if attempt.stays(cell)}
        if assumed == still:
            return attempt.loop(still)
        assumed = still if assumed is None else still & assumed


class _Attempt:
    """The loop if some numbers of the state are constant; None: all that are known at the start."""

    def __init__(
        self, iteration: Iteration, moves: Sequence[np.ndarray], assumed: set[Key] | None
    ) -> None:
        self.old, self.new, self.iteration, self.assumed = (
            iteration.graph,
            Graph(most=MOST),
            iteration,
            assumed,
        )
        self.cells: dict[Key, Carried] = {}
        self._zero = self.new.constant(0.0)
        starts = [k for cell in iteration.cells for k in cell.start if k is not None]
        ends = [pair for cell in iteration.cells for pair in (cell.input, cell.after)]
        then = [k for pair in (*ends, *iteration.kept) for k in pair if k is not None]
        self._tangent_nodes = tangent_nodes(self.old)
        self._rebuilt = Rewriter(self.old, self.new)
        self._moves = moves
        known: list[dict[int, int]] = [{} for _ in range(1 + len(moves))]
        self._write(self.old.reached(starts), known)
        self._fix(known)
        self._write(self.old.reached(then), known)
        for (k, part), cell in self._parts():
            self.cells[k, part] = Carried(*(known[part][node] for node in cell))
        wanted = [iteration.cells[k].input for k in iteration.total]
        self.total = [self._row(pair, known) for pair in wanted]
        self.kept = [self._row(pair, known) for pair in iteration.kept]

    def _write(self, order: list[int], known: list[dict[int, int]]) -> None:
        """Write values once and derivatives in each direction, in the traced order.

        So a processor has derivatives to work on while it waits for a value.
        """
        for entry in order:
            if entry not in self._tangent_nodes:
                self._rebuilt.write(entry, known[0])
                for one in known[1:]:
                    one[entry] = known[0][entry]
                continue
            node = self.old.nodes[entry]
            for direction, one in enumerate(known[1:]):
                if node.op == "input" and entry not in one:
                    group, number = node.value[:2]
                    moving = group == "ds" or self._moves[direction][number]
                    name = (*node.value, direction)
                    one[entry] = self.new.input(name) if moving else self._zero
                self._rebuilt.write(entry, one)

    def _fix(self, known: list[dict[int, int]]) -> None:
        """Replace entries that are assumed constant by their numbers at the start."""
        for key, cell in self._parts():
            one = known[key[1]]
            fixed = self.assumed is None or key in self.assumed
            if fixed and self.new.is_constant(one[cell.start]):
                for each in known if key[1] == 0 else [one]:
                    each[cell.input] = one[cell.start]

    def _parts(self) -> Iterator[tuple[Key, Carried]]:
        """The state's numbers and their derivatives, by nodes of the iteration."""
        for k, cell in enumerate(self.iteration.cells):
            for part in range(1 + len(self._moves)):
                at, start, after = (pair[min(part, 1)] for pair in cell)
                if at is not None and start is not None and after is not None:
                    yield (k, part), Carried(at, start, after)

    def _row(self, pair: Pair, known: list[dict[int, int]]) -> list[int]:
        """A number and its derivatives."""
        at, (values, *slopes) = pair.slope, known
        return [values[pair.value], *(self._zero if at is None else one[at] for one in slopes)]

    def stays(self, cell: Carried) -> bool:
        """Whether a number known at the start was assumed constant, and is."""
        return self.new.is_constant(cell.input) and cell.input == cell.after

    def loop(self, still: set[Key]) -> Loop:
        """The loop, without unneeded nodes."""
        by_input = {cell.input: cell for key, cell in self.cells.items() if key not in still}
        seen: dict[int, Carried] = {}
        rows = [*self.kept, *self.total]
        ahead = [k for row in rows for k in row]
        while ahead:
            new = [by_input[k] for k in self.new.reached(ahead) if k in by_input and k not in seen]
            seen |= {cell.input: cell for cell in new}
            ahead = [cell.after for cell in new]
        carried = [cell for _, cell in sorted(seen.items())]
        return Loop(self.new, carried, self.total, self.kept, len(rows[0]) - 1 if rows else 0)


def tangent_nodes(graph: Graph) -> set[int]:
    """Nodes that depend on a derivative."""
    found: set[int] = set()
    for k, node in enumerate(graph.nodes):
        own = node.op == "input" and node.value[0] in ("dp", "ds")
        if own or not found.isdisjoint(node.args):
            found.add(k)
    return found


def depends_only_on(graph: Graph, groups: Collection[str]) -> set[int]:
    """Nodes that depend on inputs of these groups alone."""
    found: set[int] = set()
    for k, node in enumerate(graph.nodes):
        if (node.op != "input" or node.value[0] in groups) and found.issuperset(node.args):
            found.add(k)
    return found
