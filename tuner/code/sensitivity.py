"""Derivatives of all results with respect to every constant of a step, in one pass backwards."""

from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Any

import numpy as np

from tuner.code.array_step import Given, Step
from tuner.code.mutants import CHANGE, WHOLE, Mutant
from tuner.code.nodes import Node

_WEIGHTINGS = 4
"""Random sums of the results whose derivatives are taken together."""
_SHIFT = 1e-6
"""Half the distance of a difference quotient, over the operand."""


def sensitivities(
    step: Step,
    given: Given,
    scales: np.ndarray,
    draw: np.random.Generator,
    whole: Collection[int] = (),
) -> dict[Mutant, np.ndarray]:
    """By how much a change of each constant moves the results of steps, ``(B,)`` each.

    The root of the sum of squared moves, each over its scale, to first order and estimated with
    random weights: all constants are had at the price of a few evaluations of the step. A limit
    that is passed has no derivative, and is 0 here.

    Args:
        step: the filter's.
        given: states and samples.
        scales: a size of each result, ``(roots, B)``.
        draw: a generator.
        whole: operations whose results are changed by the same share, as if they had a factor.
    """
    count = scales.shape[1]
    values: dict[int, np.ndarray] = dict.fromkeys(step.order, np.zeros(1))
    step.results(given, watched=values)
    adjoints: dict[int, np.ndarray] = {}
    with np.errstate(all="ignore"):
        for root, scale in zip(step.roots, scales, strict=True):
            weights = draw.normal(size=(_WEIGHTINGS, 1)) / scale
            adjoints[root] = adjoints.get(root, 0.0) + np.where(np.isfinite(weights), weights, 0.0)
        found: dict[Mutant, np.ndarray] = {}
        constants = {(one.node, one.at) for one in step.mutants}
        for k in reversed(step.order):
            node, adjoint = step.graph.nodes[k], adjoints.pop(k, None)
            if adjoint is None or not node.args:
                continue
            if k in whole:
                found[Mutant(k, WHOLE)] = _size(adjoint * values[k] * CHANGE, count)
            given_here = [values[part] for part in node.args]
            for at, slope in _slopes(node, step.functions[k], given_here):
                part = node.args[at]
                if not step.graph.nodes[part].args and (k, at) not in constants:
                    continue
                share = _times(adjoint, slope)
                if (k, at) in constants:
                    moved = share * (CHANGE * step.graph.nodes[part].value)
                    found[Mutant(k, at)] = _size(moved, count)
                else:
                    before = adjoints.get(part)
                    adjoints[part] = share if before is None else before + share
    none = np.zeros(count)
    wanted = [*step.mutants, *(Mutant(k, WHOLE) for k in sorted(whole))]
    return {one: found.get(one, none) for one in wanted}


def _size(moved: np.ndarray, count: int) -> np.ndarray:
    """The root of the mean of squares over all weightings, in each step."""
    return np.broadcast_to(np.sqrt((moved**2).mean(axis=0)), count)


def _times(adjoint: np.ndarray, slope: np.ndarray | int) -> np.ndarray:
    if isinstance(slope, int):
        return adjoint if slope == 1 else -adjoint
    return np.asarray(adjoint * _finite(slope))


def _finite(slope: np.ndarray) -> np.ndarray:
    """The same, or zero where it is no number; most have none of those."""
    if np.isnan(slope @ np.zeros(len(slope))):
        return np.where(np.isfinite(slope), slope, 0.0)
    return slope


def _slopes(
    node: Node, function: Callable[..., Any] | None, args: Sequence[np.ndarray]
) -> Iterator[tuple[int, Any]]:
    """The operands that an operation depends on smoothly, with its partial derivatives."""
    if node.kind != "real" or function is None:
        return
    if node.op in ("add", "sub"):
        yield from ((0, 1), (1, 1 if node.op == "add" else -1))
    elif node.op == "mul":
        yield from ((0, args[1]), (1, args[0]))
    elif node.op == "div":
        yield from ((0, 1 / args[1]), (1, -args[0] / args[1] ** 2))
    elif node.op == "neg":
        yield 0, -1
    elif node.op == "choose":
        chosen = np.asarray(args[0], bool)
        yield from ((1, np.where(chosen, 1.0, 0.0)), (2, np.where(chosen, 0.0, 1.0)))
    elif node.op != "convert":
        for at, x in enumerate(args):
            h = _SHIFT * np.maximum(np.abs(x), _SHIFT)
            ends = [function(*args[:at], x + side, *args[at + 1 :]) for side in (h, -h)]
            yield at, (ends[0] - ends[1]) / (2 * h)
