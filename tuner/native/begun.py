"""A loop that begins with what another one carries."""

from tuner.code.graph import Graph
from tuner.native.loop import Carried, Loop
from tuner.native.rewriting import Rewriter


def written(loop: Loop, graph: Graph, known: dict[int, int]) -> None:
    """Write the nodes of a sample into another graph.

    Args:
        loop: the loop.
        graph: the other graph.
        known: its nodes by those of the loop, of which some are there already; grows.
    """
    writer = Rewriter(loop.graph, graph)
    roots = [k for cell in loop.carried for k in (cell.input, cell.after)]
    rows = [k for row in (*loop.kept, *loop.total) for k in row]
    for k in loop.graph.reached([*roots, *rows]):
        writer.write(k, known)


def begun(loop: Loop, graph: Graph, known: dict[int, int]) -> Loop:
    """The same loop, begun with inputs ``("before", k)``: with the k-th number that it carries.

    Those that are not needed are not carried, and neither are those whose nodes are known before.

    Args:
        loop: the loop.
        graph: the graph it is written into.
        known: as of :func:`written`.
    """
    given = set(known)
    written(loop, graph, known)
    cells = {}
    for k, cell in enumerate(loop.carried):
        if cell.input not in given:
            start = graph.input(("before", k), loop.graph.nodes[cell.input].kind)
            cells[known[cell.input]] = Carried(known[cell.input], start, known[cell.after])
    kept, total = ([[known[k] for k in row] for row in rows] for rows in (loop.kept, loop.total))
    seen: dict[int, Carried] = {}
    ahead = [k for row in (*kept, *total) for k in row]
    while ahead:
        new = [cells[k] for k in graph.reached(ahead) if k in cells and k not in seen]
        seen |= {cell.input: cell for cell in new}
        ahead = [cell.after for cell in new]
    return Loop(graph, [cell for _, cell in sorted(seen.items())], total, kept, loop.directions)
