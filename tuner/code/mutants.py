"""Constants of a formula that are changed one at a time, each where one operation uses it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from tuner.code.graph import Graph
from tuner.code.nodes import Node
from tuner.code.operations import STEPPED

CHANGE = 1e-3
"""A constant is changed by this share of itself."""


OTHERWISE, WHOLE = -1, -2
"""In place of an operand: the decision itself is taken the other way round, or the result is
changed as if it had one factor more."""


class Mutant(NamedTuple):
    """A constant, where one operation uses it, or a decision that is taken otherwise.

    Attributes:
        node: the operation.
        at: which of its operands the constant is; or that it decides otherwise.
        limit: whether of a limit only the comparison with it is changed, which is a number of its
            own in C.
    """

    node: int
    at: int
    limit: bool = False


_OTHERWISE: Mapping[str, Callable[..., Any]] = {
    "max": np.minimum,
    "min": np.maximum,
    "round": lambda x: np.rint(x) + 1,
    "add": lambda x, y: 2 * (x + y),
}
Lanes: TypeAlias = Mapping[Mutant, Sequence[int]]
"""The rows of an array in which a constant is changed."""


def mutants_of(graph: Graph, order: Sequence[int]) -> Iterator[Mutant]:
    """The constants of operations, but zeros and results that are constant."""
    nodes = graph.nodes
    for k in order:
        for at, part in enumerate(nodes[k].args):
            one = nodes[part]
            if one.op == "constant" and one.kind == "real" and _changes(one):
                yield Mutant(k, at)
                if nodes[k].op in ("max", "min"):
                    yield Mutant(k, at, limit=True)


def limits_of(graph: Graph, order: Sequence[int], roots: Sequence[int]) -> set[Mutant]:
    """The constants that only decide between results, which depend on them in no smooth way.

    Args:
        graph: of a step.
        order: its nodes.
        roots: its results.
    """
    smooth = set(roots)
    for k in reversed(order):
        if k in smooth and graph.nodes[k].op not in STEPPED:
            smooth.update(graph.nodes[k].args)
    return {
        one
        for one in mutants_of(graph, order)
        if one.limit or one.node not in smooth or graph.nodes[one.node].op in STEPPED
    }


def uses_of(graph: Graph, order: Sequence[int], mutants: Sequence[Mutant]) -> list[Mutant]:
    """Where results of operations with a constant are used, if more than one operation does.

    Formulas have such a result once. C with loops works some of them out each time anew, with a
    number of its own.

    Args:
        graph: of a step.
        order: its nodes.
        mutants: its constants.
    """
    own, found = {one.node for one in mutants}, dict[int, list[Mutant]]()
    for k in order:
        for at, part in enumerate(graph.nodes[k].args):
            if part in own:
                found.setdefault(part, []).append(Mutant(k, at))
    return [one for uses in found.values() if len(uses) > 1 for one in uses]


def _changes(node: Node) -> bool:
    return bool(np.isfinite(node.value)) and node.value != 0


def with_changes(
    graph: Graph,
    k: int,
    function: Callable[..., Any],
    args: Sequence[np.ndarray],
    lanes: Lanes,
    M: int,
    by: float,
) -> np.ndarray:
    """The results of an operation whose constants are changed in some rows, ``(M, B)``.

    Args:
        graph: of the operation.
        k: the operation.
        function: what it is in NumPy.
        args: its operands.
        lanes: the rows of each constant.
        M: number of rows.
        by: factor of a changed constant.
    """
    node = graph.nodes[k]
    args = list(args)
    limit = None
    for at in range(len(args)):
        own = lanes.get(Mutant(k, at), [])
        if own:
            args[at] = np.repeat(args[at][None], M, axis=0) * np.ones((M, 1))
            args[at][own] *= by
        if Mutant(k, at, limit=True) in lanes:
            limit = at, lanes[Mutant(k, at, limit=True)]
    found = np.asarray(function(*args))
    turned = lanes.get(Mutant(k, OTHERWISE), [])
    if turned:
        other = _OTHERWISE[node.op](*args) if node.op in _OTHERWISE else np.logical_not(found)
        found, other = (np.array(np.broadcast_to(x, (M, found.shape[-1]))) for x in (found, other))
        found[turned] = other[turned]
    if limit is not None:
        at, own = limit
        x, plain = args[1 - at], np.asarray(graph.nodes[node.args[at]].value)
        moved = plain * by
        full = np.array(np.broadcast_to(found, np.broadcast_shapes(found.shape, (M, 1), x.shape)))
        rows = np.broadcast_to(x, full.shape)[own]
        inside = rows <= moved if node.op == "max" else rows >= moved
        full[own] = np.where(inside, plain, rows)
        found = full
    return found
