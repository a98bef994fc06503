"""The operations of scalars in NumPy, and the kinds of their results."""

import math
from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import numpy as np

Kind: TypeAlias = Literal["real", "truth", "whole"]
"""Kind of a scalar: a number, a truth value, or a whole number."""


def _whole(function: Callable[[float], float]) -> Callable[..., Any]:
    return np.vectorize(function, otypes=[float])


UNARY: dict[str, Callable[..., Any]] = {
    "neg": np.negative,
    "not": np.logical_not,
    "is_finite": np.isfinite,
    "isnan": np.isnan,
    "abs": np.abs,
    "sqrt": np.sqrt,
    "cbrt": np.cbrt,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "asinh": np.arcsinh,
    "acosh": np.arccosh,
    "atanh": np.arctanh,
    "exp": np.exp,
    "exp2": np.exp2,
    "expm1": np.expm1,
    "log": np.log,
    "log1p": np.log1p,
    "floor": np.floor,
    "ceil": np.ceil,
    "round": np.rint,
    "erf": _whole(math.erf),
    "erfc": _whole(math.erfc),
    "lgamma": _whole(math.lgamma),
}

BINARY: dict[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "rem": np.fmod,
    "pow": np.power,
    "atan2": np.arctan2,
    "max": np.maximum,
    "min": np.minimum,
    "eq": np.equal,
    "ne": np.not_equal,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "xor": np.logical_xor,
}

COMMUTE = frozenset({"add", "mul", "and", "or", "xor", "eq", "ne"})
COMPARE = frozenset({"eq", "ne", "lt", "le", "gt", "ge"})
STEPPED = COMPARE | {"round", "floor", "ceil"}
"""Operations whose result does not move with its operands, or jumps."""
LOGIC = COMPARE | {"and", "or", "xor", "not", "is_finite", "isnan"}
"""Operations whose result is a truth value."""


def in_numpy(op: str, *values: Any) -> Any:
    """An operation on numbers or arrays."""
    with np.errstate(all="ignore"):
        return (UNARY if len(values) == 1 else BINARY)[op](*values)


def worked_out(op: str, *values: Any) -> Any:
    """An operation on single numbers; a quotient of whole ones is whole, as in C."""
    found = in_numpy(op, *values)
    if op == "div" and {kind_of(value) for value in values} == {"whole"}:
        return int(np.trunc(found)) if np.isfinite(found) else 0
    return found


def kind_of(value: Any) -> Kind:
    """The kind of the entries of an array or a type."""
    dtype = value if isinstance(value, np.dtype) else np.asarray(value).dtype
    return "truth" if dtype.kind == "b" else "whole" if dtype.kind in "iu" else "real"
