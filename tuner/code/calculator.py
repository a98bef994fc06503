"""The compiled functions that work out a step on many states, and the codes of operations."""

import ctypes
from collections.abc import Sequence
from functools import cache
from importlib.resources import files

from tuner.cached import code_folder
from tuner.code.nodes import Node
from tuner.code.operations import BINARY, UNARY
from tuner.compiler import NoCodeError, library, use

_NAMES = "given", *UNARY, *BINARY, "choose", "copy", "whole", "whole_quotient"
_CODES = {name: k for k, name in enumerate(_NAMES)}
_TEXTS = "operations", "runs"
_OPTIONS = ("-ffp-contract=off",)
"""Every operation is rounded by itself, as in NumPy."""


def calculator() -> ctypes.CDLL | None:
    """The compiled functions; None: there is no compiler that works, or none is wanted."""
    return None if use() == "off" else _calculator()


@cache
def _calculator() -> ctypes.CDLL | None:
    codes = ", ".join(name.upper() for name in _NAMES)
    texts = [files("tuner.code").joinpath(f"{name}.c").read_text("ascii") for name in _TEXTS]
    try:
        return library("\n".join([f"enum {{ {codes} }};", *texts]), code_folder(), _OPTIONS)
    except (NoCodeError, OSError):  # no compiler that works, or no room for what it writes
        return None


def code_of(node: Node, nodes: Sequence[Node]) -> int:
    """What C calls an operation."""
    if node.op in ("input", "constant"):
        return _CODES["given"]
    if node.op == "convert":
        made_whole = node.kind == "whole" and nodes[node.args[0]].kind == "real"
        return _CODES["whole" if made_whole else "copy"]
    if node.kind == "whole" and node.op == "div":
        return _CODES["whole_quotient"]
    return _CODES[node.op]
