"""Operations on each number by itself."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np


def _div(a: np.ndarray, b: np.ndarray) -> Any:
    """Whole numbers are divided towards zero."""
    if np.result_type(a, b).kind == "f":
        return a / b
    return np.where(b == 0, -1, np.trunc(a / np.where(b == 0, 1, b))).astype(a.dtype)


def _integer_pow(x: np.ndarray, *, y: int) -> Any:
    """By repeated squares, as XLA does: no power of NumPy's is as exact."""
    if y == 0:
        return np.ones_like(x)
    result, square, left = None, x, abs(y)
    while left:
        if left & 1:
            result = square if result is None else result * square
        left >>= 1
        if left:
            square = square * square
    assert result is not None
    return result if y > 0 else 1 / result


def _round(x: np.ndarray, *, rounding_method: Any) -> Any:
    if int(rounding_method) == 1:  # to even
        return np.round(x)
    return np.copysign(np.floor(np.abs(x) + 0.5), x)


def _select(which: np.ndarray, *cases: np.ndarray) -> Any:
    if len(cases) == 2:
        return np.where(which, cases[1], cases[0])
    return np.choose(np.broadcast_to(which.astype(int), cases[0].shape), cases)


def _cast(x: np.ndarray, *, new_dtype: Any, **_: Any) -> Any:
    if np.issubdtype(new_dtype, np.bool_):
        return x != 0
    if np.issubdtype(new_dtype, np.integer) and x.dtype.kind == "f":
        ends = np.iinfo(new_dtype)
        return np.clip(np.nan_to_num(np.trunc(x)), ends.min, ends.max).astype(new_dtype)
    return x.astype(new_dtype)


def _logistic(x: np.ndarray, **_: Any) -> Any:
    small = np.exp(-np.abs(x))
    return np.where(x >= 0, 1 / (1 + small), small / (1 + small))


def _lgamma(x: float) -> float:
    return math.lgamma(x) if np.isfinite(x) and not (x <= 0 and x == int(x)) else abs(x) + np.inf


def _plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """An operation whose parameters, such as an accuracy, change nothing here."""
    return lambda *given, **_: function(*given)


_SAME: dict[str, Callable[..., Any]] = {
    "add": np.add,
    "add_any": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": _div,
    "rem": np.fmod,
    "neg": np.negative,
    "abs": np.abs,
    "sign": np.sign,
    "max": np.maximum,
    "min": np.minimum,
    "pow": np.power,
    "square": np.square,
    "sqrt": np.sqrt,
    "rsqrt": lambda x: 1 / np.sqrt(x),
    "cbrt": np.cbrt,
    "exp": np.exp,
    "exp2": np.exp2,
    "expm1": np.expm1,
    "log": np.log,
    "log1p": np.log1p,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "asinh": np.arcsinh,
    "acosh": np.arccosh,
    "atanh": np.arctanh,
    "logistic": _logistic,
    "erf": np.vectorize(math.erf, otypes=[float]),
    "lgamma": np.vectorize(_lgamma, otypes=[float]),
    "floor": np.floor,
    "ceil": np.ceil,
    "is_finite": np.isfinite,
    "eq": np.equal,
    "ne": np.not_equal,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "lt_to": np.less,
    "le_to": np.less_equal,
    "and": np.bitwise_and,
    "or": np.bitwise_or,
    "xor": np.bitwise_xor,
    "not": np.invert,
    "real": np.real,
    "imag": np.imag,
    "clamp": lambda low, x, high: np.minimum(np.maximum(x, low), high),
    "copy": np.array,
    "copy_p": np.array,
    "stop_gradient": np.array,
}
ELEMENTWISE: dict[str, Callable[..., Any]] = {
    **{name: _plain(function) for name, function in _SAME.items()},
    "integer_pow": _integer_pow,
    "round": _round,
    "select_n": _select,
    "convert_element_type": _cast,
}
