"""A time loop in C, with directions or points as lanes of the compiler's vectors."""

from collections.abc import Iterable, Sequence
from typing import Any

from tuner.code.expression import converted, limited, operation
from tuner.code.graph import Graph
from tuner.code.literal import literal, type_of
from tuner.code.nodes import Node
from tuner.code.operations import Kind
from tuner.native.lanes import HEAD, Lanes, function
from tuner.native.loop import Loop
from tuner.native.sines import sines

LONG = 4000
"""Operations beyond which it matters most that few numbers wait in memory; below, and where values
are no vectors, that a processor has derivatives to work on while it waits for a value."""

_OF_TURNS = {"sin": "{0}.sine", "cos": "{0}.cosine", "tan": "{0}.sine / {0}.cosine"}


def source(loop: Loop, lanes: int, *, points: bool) -> str:
    """A function ``run`` that runs a loop over a record.

    It takes the number of samples and of columns, the varying parameters and their derivatives,
    the record, rows of numbers, and memory for the results at the end and the values kept of
    each sample. A value is followed by its derivatives. Where lanes are points, the
    lanes of each number lie side by side, else those of each derivative.

    Args:
        loop: the loop, in one direction that stands for all lanes, or in each of several.
        lanes: their number, a power of two.
        points: whether each lane has its own point.

    Raises:
        NoCounterpartError: for a quotient of whole numbers that differs between points.
    """
    return _Source(loop, lanes, points=points).text()


class _Source:
    def __init__(self, loop: Loop, lanes: int, *, points: bool) -> None:
        self.loop, self.graph, self.count, self.points = loop, loop.graph, lanes, points
        self.wide = _varying(loop, {"p", "dp"} if points else {"dp"})
        self.names: dict[int, str] = {}
        self.steady = _of(loop.graph, {"p", "dp"})
        expected = _of(loop.graph, {"u", "p"}) - self.wide
        self.lanes = Lanes(loop.graph, self.wide, expected, self.name)
        self.lines: list[str] = []
        self._inverse: set[int] = set()
        self._angles: set[int] = set()

    def text(self) -> str:
        """The whole text."""
        before, sample, after = self._before(), self._sample(), self._after()
        used = sorted(self.lanes.functions.items())
        main = [
            "void run(size_t n, size_t width, const double *p, const double *dp, const double *u,",
            "         double *end, double *kept)",
            "{",
            "    const lanes zero = {0};",
            "    const masks none = {0};",
            *before,
            "    for (size_t i = 0; i < n; i++, u += width) {",
            *(f"    {line}" for line in sample),
            "    }",
            *after,
            "}",
        ]
        functions = [function(name, takes, self.count) for name, takes in used]
        head = HEAD.format(bytes=8 * self.count)
        turned = [sines()] if self._angles else []
        return "\n".join([head, *turned, *functions, "\n".join(main), ""])

    def _before(self) -> list[str]:
        """The code of parameters, of values that follow from them, and of the initial state."""
        self.lines = []
        for k, value in self._inputs("p", "dp"):
            self._load(k, value)
        carried = self.loop.carried
        for number, cell in enumerate(carried):
            self.names[cell.input] = f"s{number}"
        rows = [*self.loop.kept, *self.loop.total]
        asked = [k for cell in carried for k in (cell.start, cell.after)]
        self._statements([*asked, *(k for row in rows for k in row)], steady=True)
        for n, cell in enumerate(carried):
            text = self._of_type(cell.input, cell.start)
            self.lines.append(f"    {self._type(cell.input)} S{n} = {text};")
        return self.lines

    def _sample(self) -> list[str]:
        """The code of one sample."""
        self.lines = []
        carried = self.loop.carried
        for k, (_, column) in self._inputs("u"):
            self.names[k] = f"x{column}"
            self.lines.append(f"    {_column(self.graph.nodes[k].kind, column)}")
        for n, cell in enumerate(carried):
            self.lines.append(f"    const {self._type(cell.input)} s{n} = S{n};")
        rows = [k for row in self.loop.kept for k in row]
        self._statements([*(cell.after for cell in carried), *rows], steady=False)
        for n, cell in enumerate(carried):
            self.lines.append(f"    S{n} = {self._of_type(cell.input, cell.after)};")
        for row in self.loop.kept:
            self._put(row, "kept")
        return self.lines

    def _after(self) -> list[str]:
        """The code after the last sample."""
        self.lines = []
        for n, cell in enumerate(self.loop.carried):
            self.names[cell.input] = f"S{n}"
        for row in self.loop.total:
            self._put(row, "end")
        return self.lines

    def _inputs(self, *groups: str) -> list[tuple[int, Any]]:
        nodes = enumerate(self.graph.nodes)
        return [(k, n.value) for k, n in nodes if n.op == "input" and n.value[0] in groups]

    def _load(self, k: int, value: Sequence[Any]) -> None:
        """Load a number of the parameters, or its derivatives."""
        group, number, *direction = value
        name = self.names[k] = "_".join(map(str, value))
        if k not in self.wide:
            kind = self.graph.nodes[k].kind
            cast = {"real": "", "whole": "(int)", "truth": "0.0 != "}[kind]
            self.lines.append(f"    const {self._type(k)} {name} = {cast}{group}[{number}];")
            return
        block = number * self.loop.directions + direction[0] if direction else number
        self.lines.append(f"    lanes {name};")
        each = f"for (int j = 0; j < {self.count}; j++)"
        self.lines.append(f"    {each} {name}[j] = {group}[{block * self.count} + j];")

    def _statements(self, roots: Iterable[int], *, steady: bool) -> None:
        """Add statements for needed nodes: those that no sample changes, or the rest."""
        ordered = _depth_first if self.points or self.loop.operations > LONG else Graph.reached
        for k in ordered(self.graph, roots):
            known = k in self.names or self.graph.nodes[k].op in ("constant", "input")
            if known or (k in self.steady) != steady:
                continue
            text = self._as_sum(k) or (self._wide_text(k) if k in self.wide else self._text(k))
            self.names[k] = f"t{k}"
            self.lines.append(f"    const {self._type(k)} t{k} = {text};")

    def _as_sum(self, k: int) -> str:
        """Twice a number as a sum, which leaves the multipliers free; "" for any other node."""
        node = self.graph.nodes[k]
        for at, other in (node.args, node.args[::-1]) if node.op == "mul" else ():
            if node.kind == "real" and self.graph.is_constant(at, 2.0):
                return f"{self.name(other)} + {self.name(other)}"
        return ""

    def _wide_text(self, k: int) -> str:
        """An operation on lanes; the inverse of a common divisor is computed once."""
        node = self.graph.nodes[k]
        if node.op != "div" or node.args[1] in self.wide:
            return self.lanes.text(k)
        x, y = node.args
        if y not in self._inverse:
            self._inverse.add(y)
            self.lines.append(f"    const double over{y} = 1.0 / {self.name(y)};")
        return f"{self.name(x)} * over{y}"

    def _text(self, k: int) -> str:
        node = self.graph.nodes[k]
        given = [self.name(one) for one in node.args]
        kinds: list[Kind] = [self.graph.nodes[one].kind for one in node.args]
        if node.op == "choose":
            return f"{given[0]} ? {given[1]} : {given[2]}"
        if node.op in _OF_TURNS:
            return self._of_turn(node)
        if node.op == "convert":
            return converted(given[0], kinds[0], node.kind, "double")
        if node.op in ("max", "min"):
            for at, entry in enumerate(node.args):
                if self.graph.is_constant(entry):
                    return limited(node.op, given[1 - at], given[at])
        return operation(node.op, given, kinds, "double")

    def _of_turn(self, node: Node) -> str:
        """Sine, cosine or tangent of an angle, of which the first two are computed once."""
        (x,) = node.args
        if x not in self._angles:
            self._angles.add(x)
            self.lines.append(f"    const pair turned{x} = circular({self.name(x)});")
        return _OF_TURNS[node.op].format(f"turned{x}")

    def name(self, k: int) -> str:
        """A node as an operand."""
        node = self.graph.nodes[k]
        if node.op != "constant":
            return self.names[k]
        text = literal(node.value, node.kind, "double")
        return f"({text})" if text.startswith(("-", "(")) else text

    def _type(self, k: int) -> str:
        kind = self.graph.nodes[k].kind
        if k not in self.wide:
            return type_of(kind, "double")
        return "masks" if kind == "truth" else "lanes"

    def _of_type(self, other: int, k: int) -> str:
        """A node of the type of another one, which may be a vector."""
        return self.lanes.broad(k) if other in self.wide else self.name(k)

    def _put(self, row: Sequence[int], where: str) -> None:
        """Write a value and its derivatives."""
        value, *slopes = row
        if self.points:
            slopes = [value, *slopes]
        else:
            self.lines.append(f"    *{where}++ = (double){self.name(value)};")
        for k in slopes:
            each = f"for (int j = 0; j < {self.count}; j++)"
            self.lines.append(f"    {each} *{where}++ = {self._lane(k)};")

    def _lane(self, k: int) -> str:
        """A lane of a node as a number."""
        if k not in self.wide:
            return f"(double){self.name(k)}"
        return f"{self.name(k)}[j]{' ? 1.0 : 0.0' if self.graph.nodes[k].kind == 'truth' else ''}"


def _column(kind: Kind, column: int) -> str:
    return {
        "real": f"const double x{column} = u[{column}];",
        "truth": f"const bool x{column} = u[{column}] != 0.0;",
        "whole": f"const int x{column} = (int)u[{column}];",
    }[kind]


def _varying(loop: Loop, seeds: set[str]) -> set[int]:
    """Nodes that differ between lanes: those that depend on the seeds, also over time."""
    graph, wide = loop.graph, set[int]()
    while True:
        before = len(wide)
        for k, node in enumerate(graph.nodes):
            if (node.op == "input" and node.value[0] in seeds) or not wide.isdisjoint(node.args):
                wide.add(k)
        wide |= {c.input for c in loop.carried if c.start in wide or c.after in wide}
        if len(wide) == before:
            return wide


def _of(graph: Graph, groups: set[str]) -> set[int]:
    """Nodes that depend on inputs of these groups alone."""
    found: set[int] = set()
    for k, node in enumerate(graph.nodes):
        if (node.op != "input" or node.value[0] in groups) and found.issuperset(node.args):
            found.add(k)
    return found


def _depth_first(graph: Graph, roots: Iterable[int]) -> list[int]:
    """Nodes that the roots depend on, each just before the first that needs it."""
    done, order = set[int](), list[int]()
    for root in roots:
        ahead = [(root, False)]
        while ahead:
            k, made = ahead.pop()
            if made:
                order.append(k)
            elif k not in done:
                done.add(k)
                ahead += [(k, True), *((part, False) for part in reversed(graph.nodes[k].args))]
    return order
