"""A pass over a record and a pass back, without constant entries."""

from collections.abc import Iterable
from dataclasses import dataclass

from tuner.code.graph import Graph, TooLargeError
from tuner.code.nodes import Node
from tuner.native.earliest import earliest
from tuner.native.loop import Carried
from tuner.native.reversal import MOST_TRACED, Reversal
from tuner.native.rewriting import Rewriter
from tuner.native.stored import cheapest

MOST = 20_000
"""Most operations for a sample in both passes, for C: more compile too long."""
IN_ORDER = 6000
"""Operations up to which sums and statements are put in order: of more, too many numbers wait."""
_WAY_BACK = frozenset({"w", "v", "e"})
"""Groups of inputs that are known on the way back alone."""


@dataclass(frozen=True, eq=False)
class Passes:
    """Both passes.

    Attributes:
        graph: of the nodes; an input ``("e", k)`` is the score's derivative by the k-th number
            needed at the end.
        carried: numbers carried over time, in the pass forwards.
        weights: the score's derivatives by them, carried in the pass back.
        total: the numbers needed at the end.
        kept: the values kept of a sample.
        slopes: the derivatives in a sample by varying numbers that have any.
        begun: the derivatives by the numbers that are starts, after the pass back.
        stored: what the pass back reads of a sample; it computes the rest from this.
        back: nodes of the pass back.
    """

    graph: Graph
    carried: list[Carried]
    weights: list[Carried]
    total: list[int]
    kept: list[int]
    slopes: dict[int, int]
    begun: dict[int, int]
    stored: list[int]
    back: set[int]

    @property
    def operations(self) -> int:
        """Number of operations for a sample in both passes."""
        ends = [cell.after for cell in (*self.carried, *self.weights)]
        roots = [*ends, *self.kept, *self.slopes.values(), *self.stored]
        nodes = (self.graph.nodes[k] for k in self.graph.reached(roots))
        return sum(node.op not in ("constant", "input") for node in nodes)


def passes(reversal: Reversal) -> Passes:
    """Both passes of a loop.

    What is a number at the start and the same number after a sample is one for good, and so is a
    derivative that no sample changes; most are zeros, and what they are multiplied with goes with
    them.

    Raises:
        TooLargeError: for more operations than :data:`MOST`.
    """
    assumed: set[int] | None = None
    while True:
        attempt = _Attempt(reversal, assumed)
        still = attempt.still()
        if assumed == still:
            found = attempt.passes()
            if found.operations > MOST:
                raise TooLargeError(f"the step and its way back take more than {MOST} operations")
            if found.operations > IN_ORDER:
                return found
            attempt.put_in_order()
            return attempt.passes()
        assumed = still if assumed is None else still & assumed


class _Attempt:
    """Both passes, if some numbers are constant: given by their input nodes, None: all."""

    def __init__(self, reversal: Reversal, assumed: set[int] | None) -> None:
        self.reversal, self.assumed = reversal, assumed
        self.old, self.new = reversal.graph, Graph(most=MOST_TRACED)
        self.known: dict[int, int] = {}
        self._writer = Rewriter(self.old, self.new)
        cells = reversal.cells
        self._write(self.old.reached(cell.start for cell in cells))
        self._fixed: set[int] = set()
        self.starts: dict[int, int] = {}
        ends = {cell: k for k, cell in enumerate(reversal.total)}
        for k, cell in enumerate(cells):
            start = self.known[cell.start]
            constant = self.new.is_constant(start)
            self._fix(cell.input, start, possible=constant)
            if cell.weight is None:
                continue
            end = self.new.input(("e", ends[k])) if k in ends else self.new.constant(0.0)
            if cell.input in self._fixed:  # no point moves it
                end = self.new.constant(0.0)
            self._fix(cell.weight, end, possible=True)
        self._write(self.old.reached(self._roots()))

    def _fix(self, entry: int, start: int, *, possible: bool) -> None:
        self.starts[entry] = start
        if possible and (self.assumed is None or entry in self.assumed):
            self.known[entry] = start
            self._fixed.add(entry)

    def _roots(self) -> Iterable[int]:
        one = self.reversal
        for cell in one.cells:
            yield from (
                k for k in (cell.input, cell.after, cell.weight, cell.slope) if k is not None
            )
        yield from (k for k, _ in one.kept)
        yield from (k for k in one.slopes if k is not None)

    def _write(self, order: Iterable[int]) -> None:
        for k in order:
            self._writer.write(k, self.known)

    def still(self) -> set[int]:
        """Which of the numbers assumed constant are."""
        pairs = []
        for cell in self.reversal.cells:
            pairs.append((cell.input, cell.after))
            if cell.weight is not None and cell.slope is not None:
                pairs.append((cell.weight, cell.slope))
        # The derivative by a constant number is left out, whatever it would be.
        left_out = {c.weight for c in self.reversal.cells if c.input in self._fixed}
        return {
            start
            for start, end in pairs
            if start in self._fixed and (start in left_out or self.known[start] == self.known[end])
        }

    def put_in_order(self) -> None:
        """Put the terms of sums in the order in which they are ready."""
        pairs = [(c.input, c.after) for c in self.reversal.cells]
        for c in self.reversal.cells:
            if c.weight is not None and c.slope is not None:
                pairs.append((c.weight, c.slope))
        carried = [(self.known[a], self.known[b]) for a, b in pairs if a not in self._fixed]
        roots = [*(self.known[k] for k in self._roots()), *self.starts.values()]
        self.new, known = earliest(self.new, carried, roots)
        self.known = {k: known[node] for k, node in self.known.items() if node in known}
        self.starts = {k: known[node] for k, node in self.starts.items()}

    def passes(self) -> Passes:
        """Both, without unneeded nodes."""
        one, known, new = self.reversal, self.known, self.new
        slopes = {k: known[by] for k, by in enumerate(one.slopes) if by is not None}
        slopes = {k: by for k, by in slopes.items() if not new.is_constant(by, 0.0)}
        cells = [one.cells[k] for k in one.begun]
        first = {
            len(one.slopes) + k: known[cell.weight]
            for k, cell in enumerate(cells)
            if cell.weight is not None
        }
        begun = {k: by for k, by in first.items() if not new.is_constant(by, 0.0)}
        moving = [c for c in one.cells if c.weight is not None and c.weight not in self._fixed]
        back = [
            Carried(known[c.weight], self.starts[c.weight], known[c.slope])
            for c in moving
            if c.weight is not None and c.slope is not None
        ]
        weights = _needed(new, back, [*slopes.values(), *begun.values()])
        ends = [*slopes.values(), *(cell.after for cell in weights)]
        of_back = _depends(new, _WAY_BACK)
        stored = _stored(new, ends, of_back)
        total = [known[one.cells[k].input] for k in one.total]
        kept = [known[k] for k, _ in one.kept]
        forth = [
            Carried(known[c.input], known[c.start], known[c.after])
            for c in one.cells
            if c.input not in self._fixed
        ]
        carried = _needed(new, forth, [*total, *kept, *stored])
        return Passes(new, carried, weights, total, kept, slopes, begun, stored, of_back)


def _needed(graph: Graph, carried: list[Carried], roots: list[int]) -> list[Carried]:
    """Those of the carried numbers that others depend on."""
    by_input = {cell.input: cell for cell in carried}
    seen: dict[int, Carried] = {}
    while roots:
        new = [by_input[k] for k in graph.reached(roots) if k in by_input and k not in seen]
        seen |= {cell.input: cell for cell in new}
        roots = [cell.after for cell in new]
    return [cell for _, cell in sorted(seen.items())]


def _depends(graph: Graph, groups: Iterable[str]) -> set[int]:
    """Nodes that depend on an input of these groups."""
    found: set[int] = set()
    for k, node in enumerate(graph.nodes):
        own = node.op == "input" and node.value[0] in groups
        if own or not found.isdisjoint(node.args):
            found.add(k)
    return found


def _stored(graph: Graph, ends: list[int], back: set[int]) -> list[int]:
    """The numbers that a sample stores for the pass back."""
    reached = [k for k in graph.reached(ends) if k in back]
    needed = {part for k in reached for part in graph.nodes[k].args} | set(ends)
    moving = _depends(graph, ("s", "u"))
    free = {k for k, node in enumerate(graph.nodes) if k not in moving or _read(node)}
    return cheapest(graph, needed - back - free, free)


def _read(node: Node) -> bool:
    """Whether a node is a number of a sample."""
    return bool(node.op == "input" and node.value[0] == "u")
