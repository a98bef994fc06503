"""Nodes as C expressions; every operand that is an expression is in brackets."""

from collections.abc import Callable, Mapping

from tuner.code.graph import Graph
from tuner.code.literal import Precision, literal, type_of
from tuner.code.nodes import Node
from tuner.code.operations import Kind

INFIX = {
    "add": "+",
    "sub": "-",
    "mul": "*",
    "div": "/",
    "eq": "==",
    "ne": "!=",
    "lt": "<",
    "le": "<=",
    "gt": ">",
    "ge": ">=",
    "and": "&&",
    "or": "||",
    "xor": "!=",
}
_PREFIX = {"neg": "-", "not": "!"}
_TESTS = {"isnan": "isnan", "is_finite": "isfinite"}
CALLS = {
    "abs": "fabs",
    "round": "rint",
    "rem": "fmod",
    **{
        name: name
        for name in [
            "sqrt",
            "cbrt",
            "sin",
            "cos",
            "tan",
            "asin",
            "acos",
            "atan",
            "sinh",
            "cosh",
            "tanh",
            "asinh",
            "acosh",
            "atanh",
            "exp",
            "exp2",
            "expm1",
            "log",
            "log1p",
            "floor",
            "ceil",
            "erf",
            "erfc",
            "lgamma",
            "pow",
            "atan2",
        ]
    },
}
"""Names of the functions of math.h, for double."""


def operation(op: str, operands: list[str], kinds: list[Kind], precision: Precision) -> str:
    """An operation on operands, of which each is a name, a call, or in brackets.

    >>> operation("add", ["x", "(-2.0)"], ["real", "real"], "double")
    'x + (-2.0)'
    >>> operation("sqrt", ["x"], ["real"], "float")
    'sqrtf(x)'
    """
    x, *more = operands
    whole = "real" not in kinds
    if op in INFIX:
        return f"{x} {INFIX[op]} {more[0]}"
    if op in _PREFIX:
        return f"{_PREFIX[op]}{x}"
    if op in ("max", "min"):
        test = f"{x} {'>' if op == 'max' else '<'} {more[0]}"
        either = f"({test})" if whole else f"(({test}) || isnan({bare(x)}))"
        return f"{either} ? {x} : {more[0]}"
    if whole and op in ("abs", "rem"):
        return f"({x} < 0) ? (-{x}) : {x}" if op == "abs" else f"{x} % {more[0]}"
    name = _TESTS.get(op) or CALLS[op] + ("f" if precision == "float" else "")
    return f"{name}({', '.join(map(bare, operands))})"


def converted(operand: str, before: Kind, after: Kind, precision: Precision) -> str:
    """A number converted to another kind."""
    if before == "truth":
        one, none = (literal(value, after, precision) for value in (1, 0))
        return f"{operand} ? {one} : {none}"
    return f"({type_of(after, precision)}){operand}"


def limited(op: str, x: str, limit: str) -> str:
    """The larger or smaller of a number and a limit that is never NaN.

    >>> limited("max", "x", "0.0")
    '(x <= 0.0) ? 0.0 : x'
    """
    return f"({x} {'<=' if op == 'max' else '>='} {limit}) ? {limit} : {x}"


def bare(text: str) -> str:
    """An operand without the brackets around all of it."""
    if not text.startswith("("):
        return text
    depth = 0
    for k, letter in enumerate(text):
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if depth == 0:
            return text[1:-1] if k == len(text) - 1 else text
    return text


class Expressions:
    """The text of nodes.

    Args:
        graph: of the nodes.
        precision: of real numbers.
        input: an input's name, by its name in the graph.
        names: nodes with a variable; may grow.
    """

    def __init__(
        self,
        graph: Graph,
        precision: Precision,
        input: Callable[[object], str],
        names: Mapping[int, str],
    ) -> None:
        self.graph, self.precision, self.input, self.names = graph, precision, input, names

    def text(self, entry: int) -> str:
        """An expression by itself."""
        return self._text_and_compound(entry)[0]

    def operand(self, entry: int) -> str:
        """An expression as an operand: in brackets where it is compound."""
        text, compound = self._text_and_compound(entry)
        return f"({text})" if compound else text

    def _text_and_compound(self, entry: int) -> tuple[str, bool]:
        """The text, and whether it is compound."""
        if entry in self.names:
            return self.names[entry], False
        node = self.graph.nodes[entry]
        if node.op == "constant":
            text = literal(node.value, node.kind, self.precision)
            return text, text.startswith(("-", "("))
        if node.op == "input":
            return self.input(node.value), False
        text = self._made(node)
        return text, not (node.op in CALLS or node.op in _TESTS) or "?" in text or "%" in text

    def _made(self, node: Node) -> str:
        given = [self.operand(k) for k in node.args]
        kinds: list[Kind] = [self.graph.nodes[k].kind for k in node.args]
        if node.op == "choose":
            return f"{given[0]} ? {given[1]} : {given[2]}"
        if node.op == "convert":
            return converted(given[0], kinds[0], node.kind, self.precision)
        if node.op in ("max", "min"):
            for k, entry in enumerate(node.args):
                if self.graph.is_constant(entry):
                    return limited(node.op, given[1 - k], given[k])
        return operation(node.op, given, kinds, self.precision)
