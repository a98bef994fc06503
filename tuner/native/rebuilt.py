"""A graph written anew, with other nodes in place of some, and with few divisions."""

from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np

from tuner.code.graph import Graph
from tuner.code.operations import Kind

_TYPES: Mapping[Kind, np.dtype] = {
    "real": np.dtype(float),
    "whole": np.dtype(int),
    "truth": np.dtype(bool),
}


def rebuilt(
    old: Graph, new: Graph, order: Iterable[int], known: dict[int, int], divisors: Mapping[int, int]
) -> None:
    """Write nodes of a graph into another one, as simply as they can be put there.

    Args:
        old: the graph.
        new: the other one.
        order: which nodes, each after those it is made of.
        known: what stands for nodes of the old graph; grows.
        divisors: by how many numbers each node divides.
    """
    for entry in order:
        if entry in known:
            continue
        node = old.nodes[entry]
        if node.op == "constant":
            known[entry] = new.constant(node.value)
        elif node.op == "input":
            known[entry] = new.input(node.value, node.kind)
        elif node.op == "choose":
            condition, yes, no = (known[k] for k in node.args)
            known[entry] = new.choose(condition, no, yes)
        elif node.op == "convert":
            known[entry] = new.convert(known[node.args[0]], _TYPES[node.kind])
        elif node.op == "div" and node.kind == "real":
            x, y = (known[k] for k in node.args)
            known[entry] = _over(new, x, y, shared=divisors[node.args[1]] > 1)
        else:
            known[entry] = new.apply(node.op, *(known[k] for k in node.args))


def divisors(graph: Graph) -> Counter[int]:
    """By how many numbers each node divides."""
    return Counter(node.args[1] for node in graph.nodes if node.op == "div")


def _over(graph: Graph, x: int, y: int, *, shared: bool) -> int:
    """A quotient; a product with the inverse, where others may have that as well."""
    node, one = graph.nodes[y], graph.constant(1.0)
    if node.op == "mul" and node.args[0] == node.args[1]:
        inverse = _over(graph, one, node.args[0], shared=False)
        return graph.apply("mul", x, graph.apply("mul", inverse, inverse))
    if node.op == "choose" and all(graph.is_constant(k) for k in node.args[1:]):
        yes, no = (graph.apply("div", one, k) for k in node.args[1:])
        return graph.apply("mul", x, graph.choose(node.args[0], no, yes))
    if shared and not graph.is_constant(y):
        return graph.apply("mul", x, graph.apply("div", one, y))
    return graph.apply("div", x, y)
