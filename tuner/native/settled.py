"""A loop whose gains have settled: what no sample changes any more is computed once.

The covariance of a Kalman filter of a constant model follows from itself alone. Once it repeats
itself, all that follows from it is constant, and so are derivatives; what is left of a sample are
a few products.
"""

from dataclasses import dataclass
from typing import NamedTuple

from tuner.code.graph import Graph
from tuner.code.nodes import Node
from tuner.native.begun import begun, written
from tuner.native.fused import fused
from tuner.native.loop import Loop, depends_only_on
from tuner.native.pipelining import pipelined

_WORTH = 0.6
"""Share of a loop's operations that the settled one has at most, if there is one."""


class Usual(NamedTuple):
    """What is taken for granted of a sample.

    Attributes:
        present: columns that are numbers.
        zero: columns that are 0: flags.
    """

    present: tuple[int, ...]
    zero: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Settled:
    """A loop of which some numbers follow from themselves alone, also once these are constant.

    Both begin with inputs ``("before", k)``: the k-th number that the loop carries.

    Attributes:
        every: the loop of every sample.
        loop: the same once these numbers are constant.
        still: their places among those that the loop carries.
        usual: what the second one takes for granted of a sample.
    """

    every: Loop
    loop: Loop
    still: tuple[int, ...]
    usual: Usual


def settled(loop: Loop) -> Settled | None:
    """The loop once what follows from itself alone has settled; None where that saves little.

    >>> from tuner.native.loop import Carried
    >>> graph = Graph()
    >>> P, x, z = (graph.input(key) for key in (("s", 0), ("s", 1), ("u", 0)))
    >>> one = graph.constant(1.0)
    >>> K = graph.apply("div", P, graph.apply("add", P, one))
    >>> after = graph.apply("add", x, graph.apply("mul", K, graph.apply("sub", z, x)))
    >>> carried = [Carried(P, one, graph.apply("sin", graph.apply("exp", K))), Carried(x, z, after)]
    >>> found = settled(Loop(graph, carried, [[x]], [], 0))
    >>> found.still, moving_operations(found.loop)
    ((0,), 3)
    """
    known, usual = _as_usual(loop, graph := Graph())
    written(loop, graph, known)
    still = _still(loop, graph, known)
    known, _ = _as_usual(loop, graph := Graph())
    for k in still:
        at = loop.carried[k].input
        known[at] = graph.input(("before", k), loop.graph.nodes[at].kind)
    found = begun(loop, graph, known)
    if not still or moving_operations(found) > _WORTH * moving_operations(loop):
        return None
    every = pipelined(fused(begun(loop, Graph(), {})))
    return Settled(every, fused(found), tuple(sorted(still)), usual)


def moving_operations(loop: Loop) -> int:
    """Number of operations of a loop that are not the same for all samples."""
    fixed = depends_only_on(loop.graph, {"p", "dp", "before"})
    return sum(k not in fixed for k in loop.needed)


def _as_usual(loop: Loop, graph: Graph) -> tuple[dict[int, int], Usual]:
    """What is known of a usual sample: nodes of a graph by those of the loop."""
    known, present, zero = dict[int, int](), set[int](), set[int]()
    nodes = loop.graph.nodes
    for k, node in enumerate(nodes):
        if _of_sample(node) and node.kind == "truth":
            zero.add(node.value[1])
        elif node.op == "isnan" and _of_sample(nodes[node.args[0]]):
            present.add(nodes[node.args[0]].value[1])
        else:
            continue
        known[k] = graph.constant(value=False)
    return known, Usual(tuple(sorted(present)), tuple(sorted(zero)))


def _of_sample(node: Node) -> bool:
    """Whether it is a number of a sample."""
    return node.op == "input" and node.value[0] == "u"


def _still(loop: Loop, graph: Graph, known: dict[int, int]) -> set[int]:
    """The carried numbers that follow from themselves alone; not sums, read at the end."""
    cells = [(known[cell.input], known[cell.after]) for cell in loop.carried]
    sums = {k for row in loop.total for k in row}
    still = {k for k, cell in enumerate(loop.carried) if cell.input not in sums}
    while True:
        moving = {cells[k][0] for k in range(len(cells)) if k not in still}
        for k, node in enumerate(graph.nodes):
            if _of_sample(node) or not moving.isdisjoint(node.args):
                moving.add(k)
        left = {k for k in still if cells[k][1] not in moving}
        if left == still:
            return still
        still = left
