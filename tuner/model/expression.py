"""Expressions of a model document, in a small grammar of their own: nothing is ever executed.

Python's ``ast`` parses the text; anything outside the lists below is refused by name. Length, depth
and size are limited, so that any text is read quickly.
"""

import ast
import warnings
from dataclasses import dataclass
from typing import TypeAlias

from tuner.names import unknown
from tuner.syntax import parsed

LONGEST, DEEPEST, LARGEST = 1000, 40, 400
"""Limits of one expression: characters, levels, and parts."""

FUNCTIONS = {
    "sin": 1, "cos": 1, "tan": 1, "asin": 1, "acos": 1, "atan": 1, "atan2": 2,
    "sinh": 1, "cosh": 1, "tanh": 1, "exp": 1, "log": 1, "sqrt": 1,
    "abs": 1, "sign": 1, "min": 2, "max": 2, "hypot": 2, "where": 3,
}  # fmt: skip
"""Functions and their numbers of arguments; ``where(a < b, c, d)`` chooses."""
CONSTANTS = {"pi": 3.141592653589793}
_BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
_COMPARED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
COMPARISONS = tuple(_COMPARED.values())


class ExpressionError(ValueError):
    """A mistake in one expression, without its place."""


@dataclass(frozen=True)
class Number:
    """A finite number."""

    value: float


@dataclass(frozen=True)
class Name:
    """A parameter, a state, an input or ``dt``."""

    name: str


@dataclass(frozen=True)
class Call:
    """An operator or a function with its arguments."""

    function: str
    arguments: tuple["Node", ...]


Node: TypeAlias = Number | Name | Call
ZERO, ONE = Number(0.0), Number(1.0)


def parse(text: str) -> Node:
    """The expression of a text.

    Both ``**`` and ``^`` are powers. Names are not looked up.

    Raises:
        ExpressionError: for anything that is not in the grammar, or too large.

    >>> parse("x^2") == Call("**", (Name("x"), Number(2.0)))
    True
    """
    if len(text) > LONGEST:
        raise ExpressionError(f"has {len(text)} characters; {LONGEST} is the most, so split it")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = parsed(text.strip().replace("^", "**"), mode="eval")
    except SyntaxError as error:
        raise ExpressionError(f"{_shown(text)} is not an expression: {error.msg}") from None
    except (ValueError, RecursionError, MemoryError):
        raise ExpressionError(f"{_shown(text)} is not an expression that can be read") from None
    return _Reader(text).node(tree.body, 0)


class _Reader:
    """A converter of one text's parts into nodes, which counts them."""

    def __init__(self, text: str) -> None:
        self.text, self.parts = text, 0

    def node(self, tree: ast.AST, depth: int) -> Node:
        """One part, with the parts inside it."""
        self.parts += 1
        if depth > DEEPEST or self.parts > LARGEST:
            raise ExpressionError(
                f"{_shown(self.text)} has more than {DEEPEST} levels or {LARGEST} parts; split it"
            )
        if isinstance(tree, ast.Constant):
            return _number(tree.value)
        if isinstance(tree, ast.Name):
            return Number(CONSTANTS[tree.id]) if tree.id in CONSTANTS else Name(tree.id)
        if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub | ast.UAdd):
            inner = self.node(tree.operand, depth + 1)
            return inner if isinstance(tree.op, ast.UAdd) else Call("neg", (inner,))
        if isinstance(tree, ast.BinOp) and type(tree.op) in _BINARY:
            sides = (self.node(side, depth + 1) for side in (tree.left, tree.right))
            return Call(_BINARY[type(tree.op)], tuple(sides))
        if isinstance(tree, ast.Call):
            return self._call(tree, depth)
        raise ExpressionError(
            f"{_shown(ast.get_source_segment(self.text, tree) or self.text)} is not allowed; write "
            "numbers, names, + - * / ** and functions such as sin(x)"
        )

    def _call(self, tree: ast.Call, depth: int) -> Node:
        if not isinstance(tree.func, ast.Name):
            raise ExpressionError(f"{_shown(self.text)} calls what is not the name of a function")
        name = tree.func.id
        if name not in FUNCTIONS:
            raise ExpressionError(_no_function(name))
        if tree.keywords or len(tree.args) != FUNCTIONS[name]:
            count = len(tree.args) + len(tree.keywords)
            takes = "1 argument" if FUNCTIONS[name] == 1 else f"{FUNCTIONS[name]} arguments"
            raise ExpressionError(f"{name} takes {takes} and has {count}")
        if name != "where":
            return Call(name, tuple(self.node(each, depth + 1) for each in tree.args))
        chosen = tuple(self.node(each, depth + 1) for each in tree.args[1:])
        return Call(name, (self._compared(tree.args[0], depth + 1), *chosen))

    def _compared(self, tree: ast.AST, depth: int) -> Node:
        if not (
            isinstance(tree, ast.Compare) and len(tree.ops) == 1 and type(tree.ops[0]) in _COMPARED
        ):
            raise ExpressionError("where compares two numbers first, as in where(x > 0, x, 0)")
        sides = (self.node(side, depth + 1) for side in (tree.left, tree.comparators[0]))
        return Call(_COMPARED[type(tree.ops[0])], tuple(sides))


def _number(value: object) -> Number:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ExpressionError(f"{_shown(repr(value))} is not a real number")
    try:
        number = float(value)
    except OverflowError:
        number = float("inf")
    if not abs(number) < float("inf"):
        raise ExpressionError("contains a number beyond 1e308")
    return Number(number)


def _no_function(name: str) -> str:
    aliases = {"ln": "log", "arctan2": "atan2", "arctan": "atan", "arcsin": "asin"}
    aliases |= {"arccos": "acos", "pow": "**", "power": "**", "fabs": "abs"}
    if name in aliases:
        return f"{name!r} is not a function here; write {aliases[name]}"
    sentence = str(unknown("function", name, FUNCTIONS))
    return sentence.replace(f"unknown function {name!r};", f"{name!r} is not a function here;")


def _shown(text: str) -> str:
    return repr(text if len(text) <= 60 else f"{text[:57]}...")
