"""Derivatives that are scaled several times in a row: their factors are multiplied first.

That product is one for all directions, and known before the derivative is.
"""

from collections import Counter
from dataclasses import replace

from tuner.code.graph import Graph
from tuner.native.iteration import MOST, Cell, Iteration, Pair
from tuner.native.loop import tangent_nodes
from tuner.native.rewriting import Rewriter


def scaled(iteration: Iteration) -> Iteration:
    """The same iteration, with each derivative scaled once where nothing lies in between.

    >>> graph = Graph()
    >>> s, ds = graph.input(("s", 0)), graph.input(("ds", 0))
    >>> after = Pair(s, graph.apply("mul", graph.apply("mul", ds, s), s))
    >>> found = scaled(Iteration(graph, [Cell(Pair(s, ds), Pair(s, ds), after)], [0], []))
    >>> [node.op for node in found.graph.nodes]
    ['input', 'input', 'mul', 'mul']
    >>> found.graph.nodes[-1].args == (found.cells[0].input.slope, 2)
    True
    """
    old, new = iteration.graph, Graph(most=MOST)
    pairs = [*(pair for cell in iteration.cells for pair in cell), *iteration.kept]
    roots = [k for pair in pairs for k in pair if k is not None]
    order = old.reached(roots)
    uses = Counter(roots) + Counter(part for k in order for part in old.nodes[k].args)
    slopes = tangent_nodes(old)
    parts = {k: _parts(old, k, slopes) for k in order}
    once = {x[0] for x in parts.values() if x and uses[x[0]] == 1 and parts.get(x[0])}
    writer, known, factors = Rewriter(old, new), dict[int, int](), dict[int, tuple[int, int]]()
    for k in order:
        found = parts[k]
        if found is None:
            writer.write(k, known)
            continue
        base, factor = found[0], known[found[1]]
        if base in once:
            base, before = factors[base]
            factor = new.apply("mul", before, factor)
        factors[k] = base, factor
        if k not in once:
            known[k] = new.apply("mul", known[base], factor)

    def pair(both: Pair) -> Pair:
        return Pair(known[both.value], None if both.slope is None else known[both.slope])

    cells = [Cell(*map(pair, cell)) for cell in iteration.cells]
    return replace(iteration, graph=new, cells=cells, kept=list(map(pair, iteration.kept)))


def _parts(graph: Graph, k: int, slopes: set[int]) -> tuple[int, int] | None:
    """The derivative and the factor of a product of both; None for any other node."""
    node = graph.nodes[k]
    if node.op != "mul":
        return None
    x, y = node.args
    one, other = x in slopes, y in slopes
    if one == other:
        return None
    return (x, y) if one else (y, x)
