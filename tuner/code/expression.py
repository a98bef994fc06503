"""Nodes as expressions of C; every operand that is an expression stands in brackets."""

from collections.abc import Callable, Mapping

from tuner.code.graph import Graph
from tuner.code.literal import Precision, literal, type_of
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
CALLS = {
    "abs": "fabs",
    "round": "rint",
    "rem": "fmod",
    **{
        name: name
        for name in (
            "sqrt cbrt sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp exp2 expm1 "
            "log log1p floor ceil erf erfc lgamma pow atan2"
        ).split()
    },
}
"""What the functions of math.h are called, for double."""


def operation(op: str, operands: list[str], kinds: list[Kind], precision: Precision) -> str:
    """An operation on operands, of which each is a name, a call, or in brackets.

    >>> operation("add", ["x", "(-2.0)"], ["real", "real"], "double")
    'x + (-2.0)'
    >>> operation("sqrt", ["x"], ["real"], "float")
    'sqrtf(x)'
    """
    x, *more = operands
    if op in INFIX:
        return f"{x} {INFIX[op]} {more[0]}"
    if op in ("neg", "not"):
        return f"{'-' if op == 'neg' else '!'}{x}"
    if op in ("isnan", "is_finite"):
        return f"{'isnan' if op == 'isnan' else 'isfinite'}({bare(x)})"
    whole = "real" not in kinds
    if op == "abs" and whole:
        return f"({x} < 0) ? (-{x}) : {x}"
    if op == "rem" and whole:
        return f"{x} % {more[0]}"
    if op in ("max", "min"):
        sign = ">" if op == "max" else "<"
        test = f"{x} {sign} {more[0]}"
        return f"({test}) ? {x} : {more[0]}" if whole else f"(({test}) || isnan({bare(x)})) ? {x} : {more[0]}"
    name = CALLS[op] + ("f" if precision == "float" else "")
    return f"{name}({', '.join(map(bare, operands))})"


def converted(operand: str, before: Kind, after: Kind, precision: Precision) -> str:
    """A number of another kind."""
    if before == "truth":
        one, none = (literal(value, after, precision) for value in (1, 0))
        return f"{operand} ? {one} : {none}"
    return f"({type_of(after, precision)}){operand}"


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
        input: what an input is called, by what it is called in the graph.
        names: nodes that stand in a variable; may grow.
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
        """An expression as it stands alone."""
        return self._said(entry)[0]

    def operand(self, entry: int) -> str:
        """The same as an operand: in brackets where it is made of several."""
        text, compound = self._said(entry)
        return f"({text})" if compound else text

    def _said(self, entry: int) -> tuple[str, bool]:
        """The text, and whether it is made of several."""
        if entry in self.names:
            return self.names[entry], False
        node = self.graph.nodes[entry]
        if node.op == "constant":
            text = literal(node.value, node.kind, self.precision)
            return text, text.startswith(("-", "("))
        if node.op == "input":
            return self.input(node.value), False
        given = [self.operand(k) for k in node.args]
        kinds: list[Kind] = [self.graph.nodes[k].kind for k in node.args]
        if node.op == "choose":
            return f"{given[0]} ? {given[1]} : {given[2]}", True
        if node.op == "convert":
            return converted(given[0], kinds[0], node.kind, self.precision), True
        if node.op in ("max", "min") and self.graph.is_constant(node.args[0]):
            return self._limited(node.op, given[1], given[0]), True
        if node.op in ("max", "min") and self.graph.is_constant(node.args[1]):
            return self._limited(node.op, given[0], given[1]), True
        text = operation(node.op, given, kinds, self.precision)
        return text, not (node.op in CALLS or node.op in ("isnan", "is_finite")) or "?" in text

    def _limited(self, op: str, x: str, limit: str) -> str:
        """Between a number and a limit that is never NaN."""
        return f"({x} {'<=' if op == 'max' else '>='} {limit}) ? {limit} : {x}"
