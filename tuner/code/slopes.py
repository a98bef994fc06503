"""Derivatives of sums of a step's results in NumPy, in one pass backwards."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np

from tuner.code.array_functions import smooth_operands
from tuner.code.evaluation import Sums
from tuner.code.mutants import WHOLE, Mutant
from tuner.code.nodes import Node


def slopes(
    nodes: Sequence[Node],
    functions: Mapping[int, Callable[..., Any] | None],
    order: Sequence[int],
    values: Mapping[int, np.ndarray],
    sums: Sums,
) -> np.ndarray:
    """Sums of squared moves of weighted results, ``(M, B)``, to first order.

    Args:
        nodes: of the graph.
        functions: that make them.
        order: those of the step.
        values: of them, ``(B,)`` or ``(1,)`` each.
        sums: the weighted results, and what moves them.
    """
    rows = _rows(sums.wanted)
    squares = np.zeros((len(sums.wanted), sums.weights.shape[2]))
    adjoints: dict[int, np.ndarray] = {}
    for k, end in enumerate(sums.ends):
        adjoints[end] = adjoints.get(end, 0.0) + sums.weights[:, k]
    with np.errstate(all="ignore"):
        for k, smooth in reversed(_ways_back(nodes, order, rows)):
            adjoint = adjoints.pop(k, None)
            if adjoint is None:
                continue
            node, given = nodes[k], [values[part] for part in nodes[k].args]
            if (k, WHOLE) in rows:
                moved = adjoint * values[k] * sums.change
                np.add.reduce(moved * moved, axis=0, out=squares[rows[k, WHOLE]])
            for at in smooth:
                part = node.args[at]
                share = _times(adjoint, _slope(node, functions[k], given, at, sums.shift))
                if (k, at) in rows:
                    moved = share * (sums.change * values[part])
                    np.add.reduce(moved * moved, axis=0, out=squares[rows[k, at]])
                if nodes[part].op != "constant":
                    before = adjoints.get(part)
                    adjoints[part] = share if before is None else before + share
    return squares


def _rows(mutants: Sequence[Mutant]) -> dict[tuple[int, int], int]:
    """The places of constants, but limits, by the operations and the operands that they are."""
    return {(one.node, one.at): k for k, one in enumerate(mutants) if not one.limit}


def _ways_back(
    nodes: Sequence[Node], order: Sequence[int], rows: Collection[tuple[int, int]]
) -> list[tuple[int, list[int]]]:
    """Operations that depend on something changed smoothly, and by which operands, in order."""
    found: dict[int, list[int]] = {}
    for k in order:
        node = nodes[k]
        smooth = [at for at in smooth_operands(node) if (k, at) in rows or node.args[at] in found]
        if smooth or (k, WHOLE) in rows:
            found[k] = smooth
    return list(found.items())


def _times(adjoint: np.ndarray, slope: np.ndarray | int) -> np.ndarray:
    if isinstance(slope, int):
        return adjoint if slope == 1 else -adjoint
    return np.asarray(adjoint * (slope if slope.dtype == bool else _finite(slope)))


def _finite(slope: np.ndarray) -> np.ndarray:
    """The same, or zero where it is no number; most have none of those."""
    if np.isnan(slope @ np.zeros(len(slope))):
        return np.where(np.isfinite(slope), slope, 0.0)
    return slope


def _slope(
    node: Node,
    function: Callable[..., Any] | None,
    args: Sequence[np.ndarray],
    at: int,
    shift: float,
) -> Any:
    """The partial derivative of a smooth operation by one of its operands."""
    if node.op in ("add", "sub"):
        return -1 if node.op == "sub" and at == 1 else 1
    if node.op == "mul":
        return args[1 - at]
    if node.op == "div":
        return 1 / args[1] if at == 0 else -args[0] / args[1] ** 2
    if node.op == "neg":
        return -1
    if node.op == "choose":
        return np.asarray(args[0], bool) if at == 1 else np.logical_not(args[0])
    x = args[at]
    h = shift * np.maximum(np.abs(x), shift)
    ends = [function(*args[:at], x + side, *args[at + 1 :]) for side in (h, -h)] if function else []
    return (ends[0] - ends[1]) / (2 * h)
