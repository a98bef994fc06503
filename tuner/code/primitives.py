"""The operations of JAX on arrays of entries."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tuner.code.interpreter import Algebra, Arrays, Interpreter, Rule, each, objects
from tuner.code.operations import BINARY, UNARY
from tuner.code.rearrangements import MOVES, PLACED
from tuner.code.reductions import cumulated, place, product, reduced
from tuner.code.refused import NoCounterpartError


def _plain(op: str) -> Rule:
    def rule(algebra: Algebra, _: Any, given: Arrays) -> Arrays:
        return [each(lambda *x: algebra.apply(op, *x), *objects(algebra, given))]

    return rule


def _logic(op: str) -> Rule:
    def rule(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
        if equation.invars[0].aval.dtype != bool:
            raise NoCounterpartError(f"{op} of the bits of whole numbers has no counterpart")
        return _plain(op)(algebra, equation, given)

    return rule


def _sign(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    """The sign; that of NaN is NaN."""
    number = equation.invars[0].aval.dtype.type
    zero, one, below = (algebra.constant(number(value)) for value in (0, 1, -1))

    def of(x: Any) -> Any:
        rest = algebra.choose(algebra.apply("lt", x, zero), x, below)
        return algebra.choose(algebra.apply("gt", x, zero), rest, one)

    return [each(of, *given)]


def _rounded(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    if int(equation.params["rounding_method"]) != 1:
        raise NoCounterpartError("rounding halves away from zero has no counterpart; round to even")
    return _plain("round")(algebra, equation, given)


def _square(algebra: Algebra, _: Any, given: Arrays) -> Arrays:
    return [each(lambda x: algebra.apply("mul", x, x), *given)]


def _rsqrt(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    one = algebra.constant(equation.invars[0].aval.dtype.type(1))
    return [each(lambda x: algebra.apply("div", one, algebra.apply("sqrt", x)), *given)]


def _logistic(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    one = algebra.constant(equation.invars[0].aval.dtype.type(1))

    def of(x: Any) -> Any:
        falling = algebra.apply("exp", algebra.apply("neg", x))
        return algebra.apply("div", one, algebra.apply("add", one, falling))

    return [each(of, *given)]


def _choose(algebra: Algebra, _: Any, given: Arrays) -> Arrays:
    if len(given) != 3:
        raise NoCounterpartError("select_n of more than two has no counterpart among scalars")
    if given[0].dtype != object:
        _, no, yes = objects(algebra, given)
        return [np.where(given[0], yes, no)]
    return [each(algebra.choose, *objects(algebra, given))]


def _convert(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    before, dtype = equation.invars[0].aval.dtype, np.dtype(equation.params["new_dtype"])
    if dtype.kind == before.kind == "f" and dtype.itemsize < min(before.itemsize, _size(algebra)):
        raise NoCounterpartError(
            f"a number of {dtype} among those of {before} has no counterpart; give it no type"
        )
    if before.kind == "f" and dtype.kind == "i":
        given = [each(lambda x: _castable(algebra, x, before.type), *given)]
    return [each(lambda x: algebra.convert(x, dtype), *given)]


def _size(algebra: Algebra) -> int:
    return 4 if getattr(algebra, "precision", None) in ("float", np.float32) else 8


def _castable(algebra: Algebra, x: Any, number: type[np.floating]) -> Any:
    """A number that C can convert to int: NaN and large numbers are replaced."""
    low, high = (number(end) for end in _INT_LIMITS[_size(algebra)])
    x = algebra.choose(algebra.apply("isnan", x), x, algebra.constant(number(0)))
    x = algebra.apply("max", x, algebra.constant(low))
    return algebra.apply("min", x, algebra.constant(high))


_INT_LIMITS = {8: (-(2.0**31), 2.0**31 - 1), 4: (-(2.0**31), 2.0**31 - 128)}
"""Limits of int, as real numbers by their size in bytes."""


def _less_in_total_order(algebra: Algebra, _: Any, given: Arrays) -> Arrays:
    """Less in the total order, in which NaN is last."""

    def of(x: Any, y: Any) -> Any:
        whole = algebra.apply("not", algebra.apply("isnan", x))
        last = algebra.apply("and", whole, algebra.apply("isnan", y))
        return algebra.apply("or", algebra.apply("lt", x, y), last)

    return [each(of, *objects(algebra, given))]


def _not_behind(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    (behind,) = _less_in_total_order(algebra, equation, given[::-1])
    return [each(lambda one: algebra.apply("not", one), behind)]


def _clamp(algebra: Algebra, _: Any, given: Arrays) -> Arrays:
    def between(low: Any, x: Any, high: Any) -> Any:
        return algebra.apply("min", algebra.apply("max", x, low), high)

    return [each(between, *objects(algebra, given))]


def _power(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    one = equation.invars[0].aval.dtype.type(1)

    def times(x: Any, n: int) -> Any:
        if n < 0:
            return algebra.apply("div", algebra.constant(one), times(x, -n))
        if n < 2:
            return x if n else algebra.constant(one)
        half = times(x, n // 2)
        whole = algebra.apply("mul", half, half)
        return algebra.apply("mul", whole, x) if n % 2 else whole

    return [each(lambda x: times(x, equation.params["y"]), *given)]


_SUMS = {"sum": "add", "prod": "mul", "max": "max", "min": "min", "and": "and", "or": "or"}

_NUMBERS: Mapping[str, Callable[..., Any]] = {
    **{name: function for name, function in (UNARY | BINARY).items() if name != "isnan"},
    "add_any": np.add,
    "square": np.square,
}
"""NumPy's equivalents of JAX's operations on real numbers: nothing has to be compiled."""

RULES: Mapping[str, Rule] = {
    **{name: _plain(name) for name in (*UNARY, *BINARY) if name != "isnan"},
    **{f"reduce_{name}": reduced(op) for name, op in _SUMS.items()},
    **MOVES,
    **PLACED,
    **{name: _logic(name) for name in ("and", "or", "xor", "not")},
    "add_any": _plain("add"),
    "sign": _sign,
    "round": _rounded,
    "square": _square,
    "rsqrt": _rsqrt,
    "logistic": _logistic,
    "select_n": _choose,
    "convert_element_type": _convert,
    "lt_to": _less_in_total_order,
    "le_to": _not_behind,
    "clamp": _clamp,
    "integer_pow": _power,
    "argmax": place("gt"),
    "argmin": place("lt"),
    "cumsum": cumulated,
    "dot_general": product,
}
"""The rule of each operation."""


def interpreter(
    algebra: Algebra,
    observer: Callable[[Any, Arrays], None] | None = None,
    *,
    unrolls: bool = True,
) -> Interpreter:
    """A way through traced functions with entries of an algebra.

    Args:
        algebra: of the entries.
        observer: called with every operation and its results.
        unrolls: whether loops are unrolled, or refused.
    """
    return Interpreter(algebra, RULES, MOVES, _NUMBERS, unrolls, observer)
