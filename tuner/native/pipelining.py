"""The first slow operation of the next sample, begun while this one's derivatives are computed.

A processor starts what stands first. Where a division waits at the head of each sample for the
covariance of the one before, everything after it waits as well, and the multipliers stand idle; it
stands in the midst of the sample before instead (software pipelining, by rotation of the loop).
"""

from dataclasses import replace

from tuner.code.expression import CALLS
from tuner.code.graph import Graph
from tuner.native.loop import Carried, Loop
from tuner.native.rewriting import Rewriter

_SLOW = frozenset({"div", *CALLS})
_MOST = 64
"""Most operations that are begun ahead: of more, too much would have to be kept."""
_LONG = 1000
"""Operations of a sample that are enough to do while a division ends."""


def pipelined(loop: Loop) -> Loop:
    """The same loop, which computes its first slow operations a sample before.

    They and what they are made of are carried then. Only those count that no sample's data enter:
    of the next sample nothing is known yet.

    >>> graph = Graph()
    >>> variance, noise = graph.input(("s", 0)), graph.input(("p", 0))
    >>> gain = graph.apply("div", graph.constant(1.0), graph.apply("add", variance, noise))
    >>> cell = Carried(variance, noise, graph.apply("mul", variance, gain))
    >>> rotated = pipelined(Loop(graph, [cell], [[variance]], [], 0))
    >>> [rotated.graph.nodes[one.input].value for one in rotated.carried]
    [('ahead', 0), ('s', 0)]
    """
    head = _head(loop)
    roots = [*(cell.after for cell in loop.carried), *(k for row in loop.kept for k in row)]
    if not 0 < len(head) <= _MOST or loop.operations > _LONG:
        return loop
    old, new = loop.graph, Graph()
    rest = [k for k in old.reached(roots) if k not in head]
    outside = {part for k in rest for part in old.nodes[k].args}.union(roots)
    crossing = sorted(head & outside)
    writer = Rewriter(old, new)

    def written(order: list[int], known: dict[int, int]) -> dict[int, int]:
        for k in order:
            writer.write(k, known)
        return known

    starts = written(old.reached([cell.start for cell in loop.carried]), {})
    at_start = {cell.input: starts[cell.start] for cell in loop.carried}
    begun = written(old.reached(crossing), dict(at_start))
    now = {k: new.input(("ahead", n), old.nodes[k].kind) for n, k in enumerate(crossing)}
    inside = [cell for cell in loop.carried if cell.input in set(old.reached(crossing))]
    needed = [k for k in old.reached(cell.after for cell in inside) if k not in head]
    written(needed, now)
    after = {cell.input: now[cell.after] for cell in inside}
    then = written(old.reached(crossing), after)
    written([cell.input for cell in loop.carried] + rest, now)
    return replace(
        loop,
        graph=new,
        carried=[Carried(now[k], begun[k], then[k]) for k in crossing]
        + [Carried(now[c.input], at_start[c.input], now[c.after]) for c in loop.carried],
        kept=[[now[k] for k in row] for row in loop.kept],
        total=[[_known(k, now, writer) for k in row] for row in loop.total],
    )


def _known(entry: int, known: dict[int, int], writer: Rewriter) -> int:
    writer.write(entry, known)
    return known[entry]


def _head(loop: Loop) -> set[int]:
    """The first slow operations of a sample, and the operations that they are made of."""
    nodes = loop.graph.nodes
    carried = {cell.input for cell in loop.carried}
    moving, given, slow = set[int](), set[int](), set[int]()
    first: list[int] = []
    for k in loop.graph.reached(cell.after for cell in loop.carried):
        node = nodes[k]
        if k in carried or not moving.isdisjoint(node.args):
            moving.add(k)
        if (node.op == "input" and node.value[0] == "u") or not given.isdisjoint(node.args):
            given.add(k)
        begins = node.op in _SLOW and k in moving and k not in given
        if begins and slow.isdisjoint(node.args):
            first.append(k)
        if begins or not slow.isdisjoint(node.args):
            slow.add(k)
    found = loop.graph.reached(first)
    return {k for k in found if k in moving and k not in carried}
