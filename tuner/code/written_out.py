"""One iteration of a short loop in C, entry by entry."""

from collections.abc import Sequence

import numpy as np
from jax.extend import core

from tuner.code.block import Block
from tuner.code.flat import Statements
from tuner.code.graph import Graph
from tuner.code.interpreter import each, objects
from tuner.code.memory import Held, Lazy, Listed
from tuner.code.primitives import interpreter


def written_out(block: Block, closed: core.ClosedJaxpr, given: Sequence[Held]) -> list[Listed]:
    """The results of a traced function, whose statements a block receives.

    Args:
        block: the target.
        closed: the function.
        given: its operands.
    """
    graph = Graph(np.float64 if block.precision == "double" else np.float32)
    entries = [_entries(graph, x) for x in given]
    found = objects(graph, interpreter(graph).closed(closed, entries))
    made = Statements(
        graph,
        {},
        block.precision,
        lambda value: str(value[1]),
        stem=f"{block.fresh('s')}_",
    )
    made.add(int(k) for array in found for k in array.ravel())
    pad = "    " * (block.depth - 1)
    block.lines += [pad + line for text in made.lines for line in text.split("\n")]
    kinds = [graph.nodes[int(array.flat[0])].kind for array in found]
    texts = [each(lambda k: made.expressions.text(int(k)), array) for array in found]
    return [Listed(*pair) for pair in zip(texts, kinds, strict=True)]


def _entries(graph: Graph, x: Held) -> np.ndarray:
    """Entries of an array as nodes of a graph."""
    array = np.empty(x.shape, object)
    for index in np.ndindex(x.shape):
        if isinstance(x, Lazy) and x.number is not None:
            number = {"real": float, "whole": int, "truth": bool}[x.kind](x.number)
            array[index] = graph.constant(number)
        else:
            array[index] = graph.input(("state", x.at(index)), x.kind)
    return array
