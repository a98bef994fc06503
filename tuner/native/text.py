"""A time loop in C, with directions or points as lanes of the compiler's vectors."""

from collections.abc import Collection, Iterable, Sequence
from typing import Any

from tuner.code.graph import Graph
from tuner.code.literal import type_of
from tuner.native.lanes import HEAD, Lanes, function
from tuner.native.loop import Loop
from tuner.native.phases import Phases
from tuner.native.scalars import Scalars, read
from tuner.native.sines import sines

LONG = 4000
"""Operations beyond which it matters most that few numbers wait in memory; below, and where values
are no vectors, that a processor has derivatives to work on while it waits for a value."""


def source(both: Phases, lanes: int, *, points: bool) -> str:
    """A function ``run`` that runs a loop over a record.

    It takes the number of samples and of columns, the varying parameters and their derivatives,
    the record, rows of numbers, and memory for the results at the end and the values kept of
    each sample. A value is followed by its derivatives. Where lanes are points, the
    lanes of each number lie side by side, else those of each derivative.

    Args:
        both: the loop, in one direction that stands for all lanes, or in each of several; with the
            one before it.
        lanes: their number, a power of two.
        points: whether each lane has its own point.

    Raises:
        NoCounterpartError: for a quotient of whole numbers that differs between points.
    """
    before = None if both.first is None else _Source(both.first, lanes, points=points)
    loop = _Source(both.main, lanes, points=points, before=before)
    loops, parts = loop.text(), [loop]
    if before is not None:
        loops, parts = [*before.until(both.zero), "    {", *loops, "    }"], [before, loop]
    functions = {name: takes for part in parts for name, takes in part.lanes.functions.items()}
    main = [
        "void run(size_t n, size_t width, const double *p, const double *dp, const double *u,",
        "         double *end, double *kept)",
        "{",
        "    const lanes zero = {0};",
        "    const masks none = {0};",
        "    size_t i = 0;",
        *loops,
        "}",
    ]
    turned = [sines()] if any(part.scalars.turns for part in parts) else []
    used = [function(name, takes, lanes) for name, takes in sorted(functions.items())]
    return "\n".join([HEAD.format(bytes=8 * lanes), *turned, *used, "\n".join(main), ""])


class _Source:
    def __init__(
        self, loop: Loop, lanes: int, *, points: bool, before: "_Source | None" = None
    ) -> None:
        self.loop, self.graph, self.count, self.points = loop, loop.graph, lanes, points
        self.wide = varying(
            loop, {"p", "dp"} if points else {"dp"}, before.carried_wide if before else ()
        )
        self.scalars = Scalars(loop.graph)
        self.steady = _of(loop.graph, {"p", "dp", "before"})
        expected = _of(loop.graph, {"u", "p"}) - self.wide
        self.lanes = Lanes(loop.graph, self.wide, expected, self.name)
        self._inverse: set[int] = set()

    @property
    def carried_wide(self) -> set[int]:
        """Which of the carried numbers are vectors."""
        return {k for k, cell in enumerate(self.loop.carried) if cell.input in self.wide}

    def text(self) -> list[str]:
        """The loop, to the end of the record, and its results."""
        return [*self._before(), *self._over([]), *self._after()]

    def until(self, zero: Sequence[int]) -> list[str]:
        """The loop, up to the sample before which these carried numbers are zero."""
        wide, open_ = self.carried_wide, ["    bool open = false;"]
        each = f"for (int j = 0; j < {self.count}; j++) "
        for k in zero:
            text = f"{each}open |= S{k}[j] != 0.0;" if k in wide else f"open |= S{k} != 0.0;"
            open_.append(f"    {text}")
        return [*self._before(), *self._over([*open_, "    if (!open) break;"])]

    def _over(self, first: list[str]) -> list[str]:
        """The samples that are left, with statements at the begin of each."""
        lines = (f"    {line}" for line in (*first, *self._sample()))
        return ["    for (; i < n; i++, u += width) {", *lines, "    }"]

    def _before(self) -> list[str]:
        """The code of parameters, of values that follow from them, and of the initial state."""
        self.scalars.lines = []
        for k, (_, number) in self._inputs("before"):
            self.scalars.names[k] = f"F{number}"
            self.scalars.lines.append(f"    const {self._type(k)} F{number} = S{number};")
        for k, value in self._inputs("p", "dp"):
            self._load(k, value)
        carried = self.loop.carried
        for number, cell in enumerate(carried):
            self.scalars.names[cell.input] = f"s{number}"
        rows = [*self.loop.kept, *self.loop.total]
        asked = [k for cell in carried for k in (cell.start, cell.after)]
        self._statements([*asked, *(k for row in rows for k in row)], steady=True)
        for n, cell in enumerate(carried):
            text = self._of_type(cell.input, cell.start)
            self.scalars.lines.append(f"    {self._type(cell.input)} S{n} = {text};")
        return self.scalars.lines

    def _sample(self) -> list[str]:
        """The code of one sample."""
        self.scalars.lines = []
        carried = self.loop.carried
        for k, (_, column) in self._inputs("u"):
            self.scalars.names[k] = f"x{column}"
            kind = self.graph.nodes[k].kind
            text = f"const {type_of(kind, 'double')} x{column} = {read(kind, f'u[{column}]')};"
            self.scalars.lines.append(f"    {text}")
        for n, cell in enumerate(carried):
            self.scalars.lines.append(f"    const {self._type(cell.input)} s{n} = S{n};")
        rows = [k for row in self.loop.kept for k in row]
        self._statements([*(cell.after for cell in carried), *rows], steady=False)
        for n, cell in enumerate(carried):
            self.scalars.lines.append(f"    S{n} = {self._of_type(cell.input, cell.after)};")
        for row in self.loop.kept:
            self._put(row, "kept")
        return self.scalars.lines

    def _after(self) -> list[str]:
        """The code after the last sample."""
        self.scalars.lines = []
        for n, cell in enumerate(self.loop.carried):
            self.scalars.names[cell.input] = f"S{n}"
        for row in self.loop.total:
            self._put(row, "end")
        return self.scalars.lines

    def _inputs(self, *groups: str) -> list[tuple[int, Any]]:
        nodes = enumerate(self.graph.nodes)
        return [(k, n.value) for k, n in nodes if n.op == "input" and n.value[0] in groups]

    def _load(self, k: int, value: Sequence[Any]) -> None:
        """Load a number of the parameters, or its derivatives."""
        group, number, *direction = value
        name = self.scalars.names[k] = "_".join(map(str, value))
        if k not in self.wide:
            kind = self.graph.nodes[k].kind
            cast = {"real": "", "whole": "(int)", "truth": "0.0 != "}[kind]
            self.scalars.lines.append(
                f"    const {self._type(k)} {name} = {cast}{group}[{number}];"
            )
            return
        block = number * self.loop.directions + direction[0] if direction else number
        self.scalars.lines.append(f"    lanes {name};")
        each = f"for (int j = 0; j < {self.count}; j++)"
        self.scalars.lines.append(f"    {each} {name}[j] = {group}[{block * self.count} + j];")

    def _statements(self, roots: Iterable[int], *, steady: bool) -> None:
        """Add statements for needed nodes: those that no sample changes, or the rest."""
        ordered = _depth_first if self.points or self.loop.operations > LONG else Graph.reached
        for k in ordered(self.graph, roots):
            known = k in self.scalars.names or self.graph.nodes[k].op in ("constant", "input")
            if known or (k in self.steady) != steady:
                continue
            text = self.scalars.doubled(k) if k in self.wide else self.scalars.text(k)
            text = text or self._wide_text(k)
            self.scalars.names[k] = f"t{k}"
            self.scalars.lines.append(f"    const {self._type(k)} t{k} = {text};")

    def _wide_text(self, k: int) -> str:
        """An operation on lanes; the inverse of a common divisor is computed once."""
        node = self.graph.nodes[k]
        if node.op != "div" or node.args[1] in self.wide:
            return self.lanes.text(k)
        x, y = node.args
        if y not in self._inverse:
            self._inverse.add(y)
            self.scalars.lines.append(f"    const double over{y} = 1.0 / {self.name(y)};")
        return f"{self.name(x)} * over{y}"

    def name(self, k: int) -> str:
        """A node as an operand."""
        return self.scalars.name(k)

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
            self.scalars.lines.append(f"    *{where}++ = (double){self.name(value)};")
        for k in slopes:
            each = f"for (int j = 0; j < {self.count}; j++)"
            self.scalars.lines.append(f"    {each} *{where}++ = {self._lane(k)};")

    def _lane(self, k: int) -> str:
        """A lane of a node as a number."""
        if k not in self.wide:
            return f"(double){self.name(k)}"
        return f"{self.name(k)}[j]{' ? 1.0 : 0.0' if self.graph.nodes[k].kind == 'truth' else ''}"


def varying(loop: Loop, seeds: set[str], before: Collection[int] = ()) -> set[int]:
    """Nodes that differ between lanes: those that depend on the seeds, also over time.

    Args:
        loop: the loop.
        seeds: groups of inputs.
        before: numbers of the loop before that differ, too.
    """
    graph, nodes = loop.graph, enumerate(loop.graph.nodes)
    own = ((k, node.value) for k, node in nodes if node.op == "input")
    wide = {k for k, value in own if value[0] == "before" and value[1] in before}
    while True:
        count = len(wide)
        for k, node in enumerate(graph.nodes):
            if (node.op == "input" and node.value[0] in seeds) or not wide.isdisjoint(node.args):
                wide.add(k)
        wide |= {c.input for c in loop.carried if c.start in wide or c.after in wide}
        if len(wide) == count:
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
