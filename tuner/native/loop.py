"""A time loop with derivatives in several directions, without what never changes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from tuner.code.graph import Graph
from tuner.native.rebuilt import divisors, rebuilt
from tuner.native.turn import MOST, Pair, Turn

Key: TypeAlias = tuple[int, int]
"""A number of the state: its cell, and 0 for its value or 1 and more for its derivatives."""


class Carried(NamedTuple):
    """Nodes of what is carried over time: before a sample, at the start, after a sample."""

    input: int
    start: int
    after: int


@dataclass(frozen=True, eq=False)
class Loop:
    """A time loop.

    Attributes:
        graph: of what follows. Inputs are those of a turn; derivatives have their direction too.
        carried: what is carried over time.
        total: for each number that is asked for in the end, nodes of its value and derivatives,
            which are read after the last sample.
        kept: for each number that is kept of a sample the same.
        directions: how many derivatives each number has.
    """

    graph: Graph
    carried: list[Carried]
    total: list[list[int]]
    kept: list[list[int]]
    directions: int


def loop(turn: Turn, moves: Sequence[np.ndarray]) -> Loop:
    """Write a turn in several directions.

    What is a number at the start and the same number after a sample is one for good; most of these
    are zeros, and what they are multiplied with goes with them.

    Args:
        turn: the turn.
        moves: for each direction, which of the parameters' numbers that move do so in it.

    Raises:
        TooLargeError: for more operations than :data:`tuner.native.turn.MOST`.
    """
    assumed: set[Key] | None = None
    while True:
        attempt = _Attempt(turn, moves, assumed)
        still = {key for key, cell in attempt.cells.items() if attempt.stays(cell)}
        if assumed == still:
            return attempt.loop(still)
        assumed = still if assumed is None else still & assumed


class _Attempt:
    """The loop if some numbers of the state never change; None: all that are known at the start."""

    def __init__(self, turn: Turn, moves: Sequence[np.ndarray], assumed: set[Key] | None) -> None:
        self.old, self.new, self.turn, self.assumed = turn.graph, Graph(most=MOST), turn, assumed
        self.cells: dict[Key, Carried] = {}
        self._divisors, self._zero = divisors(self.old), self.new.constant(0.0)
        starts = [k for cell in turn.cells for k in cell.start if k is not None]
        ends = [pair for cell in turn.cells for pair in (cell.input, cell.after)]
        then = [k for pair in (*ends, *turn.kept) for k in pair if k is not None]
        self._first, self._then = self.old.reached(starts), self.old.reached(then)
        self._sloped = _sloped(self.old)
        values = self._values()
        slopes = [self._slopes(values, move, part) for part, move in enumerate(moves, 1)]
        wanted = [turn.cells[k].input for k in turn.total]
        self.total = [self._row(pair, values, slopes) for pair in wanted]
        self.kept = [self._row(pair, values, slopes) for pair in turn.kept]

    def _values(self) -> dict[int, int]:
        """Write what depends on no direction."""
        known: dict[int, int] = {}
        first = [k for k in self._first if k not in self._sloped]
        then = [k for k in self._then if k not in self._sloped]
        self._write(known, first, then, 0)
        return known

    def _slopes(self, values: dict[int, int], move: np.ndarray, part: int) -> dict[int, int]:
        """Write derivatives in a direction."""
        known = dict(values)
        for k in self._sloped:
            node = self.old.nodes[k]
            if node.op == "input":
                moving = node.value[0] == "ds" or move[node.value[1]]
                known[k] = self.new.input((*node.value, part - 1)) if moving else self._zero
        self._write(known, self._first, self._then, part)
        return known

    def _write(self, known: dict[int, int], first: list[int], then: list[int], part: int) -> None:
        """The start, what never changes, and the rest."""
        rebuilt(self.old, self.new, first, known, self._divisors)
        mine: dict[int, Carried] = {}
        for k, cell in enumerate(self.turn.cells):
            at, start, after = (pair[min(part, 1)] for pair in cell)
            if at is None or start is None or after is None:
                continue
            mine[k] = Carried(at, start, after)
            fixed = self.assumed is None or (k, part) in self.assumed
            if fixed and self.new.is_constant(known[start]):
                known[at] = known[start]
        rebuilt(self.old, self.new, then, known, self._divisors)
        for k, old in mine.items():
            self.cells[k, part] = Carried(*(known[node] for node in old))

    def _row(self, pair: Pair, values: dict[int, int], slopes: list[dict[int, int]]) -> list[int]:
        """A number and its derivatives."""
        at = pair.slope
        return [values[pair.value], *(self._zero if at is None else known[at] for known in slopes)]

    def stays(self, cell: Carried) -> bool:
        """Whether a number that is known at the start was taken to stay, and does."""
        return self.new.is_constant(cell.input) and cell.input == cell.after

    def loop(self, still: set[Key]) -> Loop:
        """The loop, without what nobody asks for."""
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


def _sloped(graph: Graph) -> set[int]:
    """Nodes that depend on a derivative."""
    found: set[int] = set()
    for k, node in enumerate(graph.nodes):
        own = node.op == "input" and node.value[0] in ("dp", "ds")
        if own or not found.isdisjoint(node.args):
            found.add(k)
    return found
