"""The operations of a step as functions of arrays."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tuner.code.nodes import Node
from tuner.code.operations import BINARY, LOGIC, UNARY

_EXACT = frozenset({"neg", "abs", "choose", "convert", "max", "min", *LOGIC})


class Work(NamedTuple):
    """A node of a step, with what makes it, and the nodes that are needed no longer after it."""

    k: int
    node: Node
    function: Callable[..., Any] | None
    rounded: bool
    done: list[int]


def work_of(
    nodes: Sequence[Node],
    functions: Mapping[int, Callable[..., Any] | None],
    order: Sequence[int],
    ends: Collection[int],
) -> list[Work]:
    """Some nodes, of which only the ends are kept.

    Args:
        nodes: of the graph.
        functions: that make them.
        order: which are made, and when.
        ends: those that are needed in the end.
    """
    done, last = dict[int, list[int]](), {part: k for k in order for part in nodes[k].args}
    for part, k in last.items():
        if part not in ends:
            done.setdefault(k, []).append(part)
    return [Work(k, nodes[k], functions[k], is_rounded(nodes[k]), done.get(k, [])) for k in order]


def is_rounded(node: Node) -> bool:
    """Whether an operation has a rounding error."""
    return node.kind == "real" and bool(node.args) and node.op not in _EXACT


def smooth_operands(node: Node) -> range:
    """The operands that an operation depends on smoothly."""
    if node.kind != "real" or node.op == "convert":
        return range(0)
    return range(1 if node.op == "choose" else 0, len(node.args))


def function_of(node: Node, nodes: Sequence[Node]) -> Callable[..., Any] | None:
    """The function of arrays that an operation is; None for an input or a constant."""
    if node.op in ("input", "constant"):
        return None
    if node.op == "choose":
        return np.where
    if node.op == "convert":
        if node.kind == "whole" and nodes[node.args[0]].kind == "real":
            return _whole
        kind = {"real": float, "whole": int, "truth": bool}[node.kind]
        return lambda x: np.asarray(x, kind)
    if node.kind == "whole" and node.op == "div":
        return _whole_quotient
    return (UNARY if len(node.args) == 1 else BINARY)[node.op]


def _whole_quotient(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Quotients of whole numbers; 0 for one by zero."""
    found = np.trunc(x / y)
    return np.where(np.isfinite(found), found, 0.0).astype(int)


def _whole(x: np.ndarray) -> np.ndarray:
    """Real numbers made whole, as in C."""
    whole = np.nan_to_num(np.trunc(x), posinf=2**31 - 1, neginf=-(2**31))
    return np.asarray(np.clip(whole, -(2**31), 2**31 - 1).astype(int))
