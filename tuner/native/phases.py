"""The two phases of a loop: until some of its numbers are zero for good, and from then on.

A start of which nothing is known takes a few measurements, and costs several times as much as what
follows: all that is carried of it is zero then, and stays so.
"""

from dataclasses import dataclass

import numpy as np

from tuner.code.by_numpy import InNumPy
from tuner.code.graph import Graph
from tuner.code.operations import Kind
from tuner.native.begun import begun, written
from tuner.native.fused import fused
from tuner.native.loop import Loop
from tuner.native.pipelining import pipelined
from tuner.native.settled import Settled, settled

_SAMPLES = 16
"""After so many it is looked which numbers are zero."""
_WORTH = 0.7
"""Share of a loop's operations that the second phase has at most, if there are two."""


@dataclass(frozen=True, eq=False)
class Phases:
    """A loop, and the loop before it.

    Attributes:
        main: the loop, whose starts are made of parameters, and of inputs ``("before", k)``: of the
            k-th number that the first one carries.
        first: the loop before; None: there is none.
        zero: which of the numbers that it carries are zero once it is over.
        settled: what comes after the main loop; None: it goes on to the end.
    """

    main: Loop
    first: Loop | None = None
    zero: tuple[int, ...] = ()
    settled: Settled | None = None


def phases(loop: Loop, *, settle: bool = True) -> Phases:
    """A loop in one phase, or in two where that is worth it.

    >>> from tuner.native.loop import Carried
    >>> graph = Graph()
    >>> x, w, z = (graph.input(key) for key in (("s", 0), ("s", 1), ("u", 0)))
    >>> one, zero = graph.constant(1.0), graph.constant(0.0)
    >>> left = graph.choose(graph.apply("lt", z, graph.constant(9.0)), one, zero)
    >>> after = graph.apply("add", graph.apply("sin", graph.apply("mul", x, w)), z)
    >>> carried = [Carried(x, one, after), Carried(w, one, graph.apply("mul", w, left))]
    >>> both = phases(Loop(graph, carried, [[x]], [], 0))
    >>> both.zero, both.first.operations, both.main.operations
    ((1,), 6, 0)
    """
    zero = _zeros(loop)
    main = begun(loop, graph := Graph(), _nothing(loop, zero, graph)) if zero else loop
    two = bool(zero) and main.operations <= _WORTH * loop.operations
    main = main if two else loop
    last = settled(main) if settle else None
    main = fused(main) if last is not None else pipelined(fused(main))
    if not two:
        return Phases(main, settled=last)
    return Phases(main, fused(loop), tuple(sorted(zero)), last)


def _nothing(loop: Loop, zero: set[int], graph: Graph) -> dict[int, int]:
    """Zeros of a graph in place of some carried numbers, by nodes of the loop."""
    return {loop.carried[k].input: graph.constant(0.0) for k in zero}


def _zeros(loop: Loop) -> set[int]:
    """The most numbers that stay zero once they are, of those that come to be so."""
    zero = _become_zero(loop)
    while zero:
        known = _nothing(loop, zero, graph := Graph())
        written(loop, graph, known)
        still = {k for k in zero if graph.is_constant(known[loop.carried[k].after], 0.0)}
        if still == zero:
            break
        zero = still
    return zero


def _become_zero(loop: Loop) -> set[int]:
    """Numbers that are zero after some samples of any kind; none, if they were before.

    Those that are read at the end of a record are left out: it may end before.
    """
    nodes, cells = loop.graph.nodes, loop.carried
    start, after = (
        InNumPy(loop.graph, loop.graph.reached(ends), ends)
        for ends in ([cell.start for cell in cells], [cell.after for cell in cells])
    )
    draw = np.random.default_rng(0)
    inputs = {*start.inputs, *after.inputs} - {cell.input for cell in cells}
    given = {k: _any(draw, nodes[k].kind) for k in sorted(inputs)}
    found = start.values(given)
    first = state = {cell.input: found[cell.start] for cell in cells}
    for _ in range(_SAMPLES):
        given |= {k: _any(draw, nodes[k].kind) for k in after.inputs if nodes[k].value[0] == "u"}
        found = after.values(given | state)
        state = {cell.input: found[cell.after] for cell in cells}
    read = {k for row in loop.total for k in row}
    real = [k for k, cell in enumerate(cells) if nodes[cell.input].kind == "real"]
    zero = {k for k in real if state[cells[k].input][0] == 0 and cells[k].input not in read}
    return zero if any(first[cells[k].input][0] != 0 for k in zero) else set()


def _any(draw: np.random.Generator, kind: Kind) -> np.ndarray:
    """A number of a kind."""
    if kind == "real":
        return draw.uniform(0.5, 1.5, 1)
    return np.ones(1, bool if kind == "truth" else int)
