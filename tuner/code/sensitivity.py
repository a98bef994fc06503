"""Derivatives of all results with respect to every constant of a step, in one pass backwards."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np

from tuner.code.array_functions import smooth_operands
from tuner.code.array_step import Step
from tuner.code.mutants import CHANGE, WHOLE, Mutant
from tuner.code.nodes import Node

_WEIGHTINGS = 4
"""Random sums of the results whose derivatives are taken together."""
_SHIFT = 1e-6
"""Half the distance of a difference quotient, over the operand."""


def sensitivities(
    step: Step,
    values: Mapping[int, np.ndarray],
    scales: np.ndarray,
    draw: np.random.Generator,
    whole: Collection[int] = (),
    uses: Sequence[Mutant] = (),
) -> dict[Mutant, np.ndarray]:
    """By how much a change of each constant moves the results of steps, ``(B,)`` each.

    The root of the sum of squared moves, each over its scale, to first order and estimated with
    random weights: all constants are had at the price of a few evaluations of the step. A limit
    that is passed has no derivative, and is 0 here.

    Args:
        step: the filter's.
        values: all its nodes, ``(B,)`` or ``(1,)`` each.
        scales: a size of each result, ``(roots, B)``.
        draw: a generator.
        whole: operations whose results are changed by the same share, as if they had a factor.
        uses: operands that are no constants and are changed by the same share, each where one
            operation uses it.
    """
    wanted = [*step.mutants, *uses, *(Mutant(k, WHOLE) for k in sorted(whole))]
    nodes, rows = step.graph.nodes, _rows(wanted)
    squares = np.zeros((len(wanted), scales.shape[1]))
    with np.errstate(all="ignore"):
        adjoints = _weighted(step.roots, scales, draw)
        for k, smooth in reversed(_ways_back(step, rows)):
            adjoint = adjoints.pop(k, None)
            if adjoint is None:
                continue
            node, given = nodes[k], [values[part] for part in nodes[k].args]
            if k in whole:
                moved = adjoint * values[k] * CHANGE
                np.add.reduce(moved * moved, axis=0, out=squares[rows[k, WHOLE]])
            for at in smooth:
                part = node.args[at]
                share = _times(adjoint, _slope(node, step.functions[k], given, at))
                if (k, at) in rows:
                    moved = share * (CHANGE * values[part])
                    np.add.reduce(moved * moved, axis=0, out=squares[rows[k, at]])
                if nodes[part].op != "constant":
                    before = adjoints.get(part)
                    adjoints[part] = share if before is None else before + share
    return dict(zip(wanted, np.sqrt(squares / _WEIGHTINGS), strict=True))


def _rows(mutants: Sequence[Mutant]) -> dict[tuple[int, int], int]:
    """The places of constants, but limits, by the operations and the operands that they are."""
    return {(one.node, one.at): k for k, one in enumerate(mutants) if not one.limit}


def _ways_back(step: Step, rows: Collection[tuple[int, int]]) -> list[tuple[int, list[int]]]:
    """Operations that depend on something changed smoothly, and by which operands, in order."""
    found: dict[int, list[int]] = {}
    for k in step.order:
        node = step.graph.nodes[k]
        smooth = [at for at in smooth_operands(node) if (k, at) in rows or node.args[at] in found]
        if smooth or (k, WHOLE) in rows:
            found[k] = smooth
    return list(found.items())


def _weighted(
    roots: Sequence[int], scales: np.ndarray, draw: np.random.Generator
) -> dict[int, np.ndarray]:
    """Random weights of the results over their scales, ``(_WEIGHTINGS, B)`` each."""
    found: dict[int, np.ndarray] = {}
    for root, scale in zip(roots, scales, strict=True):
        weights = draw.normal(size=(_WEIGHTINGS, 1)) / scale
        found[root] = found.get(root, 0.0) + np.where(np.isfinite(weights), weights, 0.0)
    return found


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
    node: Node, function: Callable[..., Any] | None, args: Sequence[np.ndarray], at: int
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
    h = _SHIFT * np.maximum(np.abs(x), _SHIFT)
    ends = [function(*args[:at], x + side, *args[at + 1 :]) for side in (h, -h)] if function else []
    return (ends[0] - ends[1]) / (2 * h)
