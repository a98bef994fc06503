"""Symbolic properties of expressions: folding, linearity, factors."""

import math
import operator
from collections.abc import Callable, Collection, Iterator
from typing import Any, TypeAlias

from tuner.model.expression import ONE, ZERO, Call, ExpressionError, Name, Node, Number

Affine: TypeAlias = tuple[dict[str, Node], Node]
_FOLDED: dict[str, Callable[..., Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "**": operator.pow, "neg": operator.neg, "abs": abs, "min": min, "max": max,
    "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "where": lambda test, a, b: a if test else b,
    **{name: getattr(math, name) for name in (
        "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp",
        "log", "sqrt", "hypot")},
}  # fmt: skip


def fold(node: Node) -> Node:
    """The expression with every constant part evaluated.

    Raises:
        ExpressionError: where such a part is not a finite real number.

    >>> from tuner.model.expression import parse
    >>> fold(parse("x * (1 + 1) + 0")) == parse("x * 2")
    True
    """
    if not isinstance(node, Call):
        return node
    return made(node.function, *(fold(each) for each in node.arguments))


def made(function: str, *arguments: Node) -> Node:
    """A function of folded arguments, folded: constants evaluated, 0 and 1 left out."""
    numbers = [each.value for each in arguments if isinstance(each, Number)]
    if len(numbers) == len(arguments):
        return _worked_out(function, numbers)
    if function == "/" and arguments[1] == ZERO:
        raise ExpressionError("divides by 0")
    if function == "where" and isinstance(test := arguments[0], Number):
        return arguments[1] if test.value else arguments[2]
    return _simpler(function, arguments) or Call(function, arguments)


def _worked_out(function: str, numbers: list[float]) -> Number:
    try:
        value = _FOLDED[function](*numbers)
        if not isinstance(value, complex) and math.isfinite(value):
            return Number(float(value))
    except (OverflowError, ZeroDivisionError, ValueError):
        pass
    shown = [f"{number:g}" for number in numbers]
    infix = function in ("+", "-", "*", "/", "**")
    text = f" {function} ".join(shown) if infix else f"{function}({', '.join(shown)})"
    raise ExpressionError(f"{text} is not a finite number")


def _simpler(function: str, arguments: tuple[Node, ...]) -> Node | None:
    """Sums with 0 and products with 0 or 1; None for any other."""
    if len(arguments) != 2:
        return None
    first, last = arguments
    found: Node | None
    if function == "+":
        found = last if first == ZERO else first if last == ZERO else None
    elif function == "-":
        found = first if last == ZERO else Call("neg", (last,)) if first == ZERO else None
    elif function == "*" and ZERO in arguments:
        found = ZERO
    elif function == "*":
        found = last if first == ONE else first if last == ONE else None
    elif function in ("/", "**") and last == ONE:
        found = first
    else:
        found = ZERO if function == "/" and first == ZERO else None
    return found


def total(terms: Iterator[Node]) -> Node:
    """The sum of terms; 0 for none."""
    found: Node = ZERO
    for term in terms:
        found = made("+", found, term)
    return found


def names_in(node: Node) -> frozenset[str]:
    """The names in an expression."""
    if isinstance(node, Name):
        return frozenset((node.name,))
    if isinstance(node, Number):
        return frozenset()
    return frozenset().union(*(names_in(each) for each in node.arguments))


def affine(node: Node, names: Collection[str]) -> Affine | None:
    """An expression as coefficients of some names and a rest; None where it is not linear in them.

    Neither coefficients nor rest hold any of the names.

    >>> from tuner.model.expression import parse
    >>> affine(parse("-k*x + u"), ["x"])
    ({'x': Call(function='neg', arguments=(Name(name='k'),))}, Name(name='u'))
    >>> affine(parse("x*x"), ["x"]) is None
    True
    """
    if isinstance(node, Name) and node.name in names:
        return {node.name: ONE}, ZERO
    free = [not names_in(each) & set(names) for each in _arguments(node)]
    if all(free):
        return {}, node
    assert isinstance(node, Call)
    function, arguments = node.function, node.arguments
    found: Affine | None = None
    if function == "neg":
        found = _scaled(arguments[0], names, lambda part: made("neg", part))
    elif function in ("+", "-"):
        found = _summed(function, arguments, names)
    elif function in ("*", "/") and free[1]:
        found = _scaled(arguments[0], names, lambda part: made(function, part, arguments[1]))
    elif function == "*" and free[0]:
        found = _scaled(arguments[1], names, lambda part: made("*", arguments[0], part))
    return found


def _arguments(node: Node) -> tuple[Node, ...]:
    return node.arguments if isinstance(node, Call) else ()


def _scaled(node: Node, names: Collection[str], by: Callable[[Node], Node]) -> Affine | None:
    found = affine(node, names)
    if found is None:
        return None
    return {name: by(part) for name, part in found[0].items()}, by(found[1])


def _summed(function: str, sides: tuple[Node, ...], names: Collection[str]) -> Affine | None:
    left, right = (affine(each, names) for each in sides)
    if left is None or right is None:
        return None
    keys = dict.fromkeys((*left[0], *right[0]))
    sums = {key: made(function, left[0].get(key, ZERO), right[0].get(key, ZERO)) for key in keys}
    return sums, made(function, left[1], right[1])


def separated(node: Node, names: Collection[str]) -> tuple[Node, Node] | None:
    """A product as a factor without some names and one of them alone; None if it is not one.

    >>> from tuner.model.expression import parse
    >>> separated(parse("s^2 * sigma^2"), ["sigma"])[1] == parse("sigma^2")
    True
    """
    found = names_in(node)
    if not found & set(names):
        return node, ONE
    if found <= set(names):
        return ONE, node
    if not isinstance(node, Call):
        return None
    if node.function in ("*", "/"):
        parts = [separated(each, names) for each in node.arguments]
        if (left := parts[0]) and (right := parts[1]):
            return made(node.function, left[0], right[0]), made(node.function, left[1], right[1])
    if node.function == "**" and isinstance(node.arguments[1], Number):
        inner = separated(node.arguments[0], names)
        if inner:
            return made("**", inner[0], node.arguments[1]), made("**", inner[1], node.arguments[1])
    return None
