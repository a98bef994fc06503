"""Operations on the compiler's vectors: numbers and truth values that differ between lanes."""

from collections.abc import Callable

from tuner.code.expression import CALLS
from tuner.code.graph import Graph
from tuner.code.operations import Kind
from tuner.code.refused import NoCounterpartError

HEAD = """\
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

typedef double lanes __attribute__((vector_size({bytes})));
typedef long long masks __attribute__((vector_size({bytes})));

static inline lanes pick(masks m, lanes yes, lanes no)
{{
    return (lanes)((m & (masks)yes) | (~m & (masks)no));
}}
"""
_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_TRUTH = {"and": "&", "or": "|", "xor": "^"}
_COMPARED = {"eq": "==", "ne": "!=", "lt": "<", "le": "<=", "gt": ">", "ge": ">="}


def function(name: str, takes: int, lanes: int) -> str:
    """A function of math.h on every lane.

    >>> print(function("exp", 1, 4))
    static inline lanes v_exp(lanes x)
    {
        for (int j = 0; j < 4; j++) x[j] = exp(x[j]);
        return x;
    }
    <BLANKLINE>
    """
    names = ("x", "y")[:takes]
    given = ", ".join(f"{one}[j]" for one in names)
    return (
        f"static inline lanes v_{name}({', '.join(f'lanes {one}' for one in names)})\n{{\n"
        f"    for (int j = 0; j < {lanes}; j++) x[j] = {name}({given});\n    return x;\n}}\n"
    )


class Lanes:
    """The text of operations whose result differs between lanes.

    Args:
        graph: of the nodes.
        wide: those that differ.
        expected: conditions that a processor predicts well, such as missing samples.
        name: of a node, as an operand.

    Attributes:
        functions: those used of math.h, with their numbers of arguments.
    """

    def __init__(
        self, graph: Graph, wide: set[int], expected: set[int], name: Callable[[int], str]
    ) -> None:
        self.graph, self.wide, self.expected, self.name = graph, wide, expected, name
        self.functions: dict[str, int] = {}

    def broad(self, k: int) -> str:
        """A node as a vector."""
        if k in self.wide:
            return self.name(k)
        if self.graph.nodes[k].kind == "truth":
            return f"(none - (long long){self.name(k)})"
        return f"(zero + {self.name(k)})"

    def text(self, entry: int) -> str:
        """An operation; whole numbers are real ones here.

        Raises:
            NoCounterpartError: for the quotient or the rest of whole numbers.
        """
        node = self.graph.nodes[entry]
        op, args = node.op, node.args
        if node.kind == "whole" and op in ("div", "rem"):
            raise NoCounterpartError("a quotient of whole numbers that differs between points")
        if op == "convert":
            return self._converted(node.kind, args[0])
        if op == "choose" and args[0] in self.expected:
            return f"{self.name(args[0])} ? {self.broad(args[1])} : {self.broad(args[2])}"
        if op in ("max", "min"):
            return self._limited(op, *args)
        if op in _INFIX:
            return f" {_INFIX[op]} ".join(map(self.name, args))
        x, *more = map(self.broad, args)
        if op in _TRUTH or op in _COMPARED:
            y = more[0]
            return f"{x} {_TRUTH[op]} {y}" if op in _TRUTH else f"(masks)({x} {_COMPARED[op]} {y})"
        return self._of_one(op, x, more)

    def _of_one(self, op: str, x: str, more: list[str]) -> str:
        plain = {
            "neg": f"-{x}",
            "not": f"~{x}",
            "isnan": f"(masks)({x} != {x})",
            "is_finite": f"(masks)({x} - {x} == zero)",
            "choose": f"pick({', '.join([x, *more])})",
        }
        if op in plain:
            return plain[op]
        self.functions[CALLS[op]] = 1 + len(more)
        return f"v_{CALLS[op]}({', '.join([x, *more])})"

    def _converted(self, kind: Kind, k: int) -> str:
        if self.graph.nodes[k].kind == "truth":
            return f"pick({self.broad(k)}, zero + 1.0, zero)"
        if kind == "real":
            return self.broad(k)
        self.functions["trunc"] = 1
        return f"v_trunc({self.broad(k)})"

    def _limited(self, op: str, one: int, other: int) -> str:
        """The larger or smaller of two; NaN if either is NaN."""
        if self.graph.is_constant(one):
            one, other = other, one
        x, y = self.broad(one), self.broad(other)
        if self.graph.is_constant(other):
            return f"pick((masks)({x} {'<=' if op == 'max' else '>='} {y}), {y}, {x})"
        first = f"(masks)({x} {'>' if op == 'max' else '<'} {y})"
        return f"pick({first} | (masks)({x} != {x}), {x}, {y})"
