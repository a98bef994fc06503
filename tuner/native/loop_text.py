"""The text of one loop, with directions or points as lanes of the compiler's vectors."""

from collections.abc import Collection, Iterable, Sequence
from typing import Any

from tuner.code.graph import Graph
from tuner.code.literal import type_of
from tuner.native.lanes import Lanes
from tuner.native.loop import Loop, depends_only_on
from tuner.native.scalars import Scalars, read
from tuner.native.schedule import scheduled

LONG = 4000
"""Operations beyond which it matters most that few numbers wait in memory; below, and where values
are no vectors, that a processor has derivatives to work on while it waits for a value."""


class LoopText:
    """Statements of a loop.

    Args:
        loop: the loop.
        lanes: their number.
        points: whether each lane has its own point.
        in_order: whether statements stand in the order in which a processor can begin them.
        before: the loop before, whose carried numbers it begins with.
        cells: the letter of its carried numbers' names.

    Attributes:
        lanes: the text of operations on lanes.
        scalars: the text of all others.
    """

    def __init__(
        self,
        loop: Loop,
        lanes: int,
        *,
        points: bool,
        in_order: bool = False,
        before: "LoopText | None" = None,
        cells: str = "S",
    ) -> None:
        self.loop, self.graph, self.count, self.points = loop, loop.graph, lanes, points
        self._in_order = in_order
        self.cells = cells
        self.wide = varying(
            loop, {"p", "dp"} if points else {"dp"}, before.carried_wide if before else ()
        )
        self.scalars = Scalars(loop.graph)
        self.steady = depends_only_on(loop.graph, {"p", "dp", "before"})
        expected = depends_only_on(loop.graph, {"u", "p"}) - self.wide
        self.lanes = Lanes(loop.graph, self.wide, expected, self.name)
        self._inverse: set[int] = set()

    @property
    def carried_wide(self) -> set[int]:
        """Which of the carried numbers are vectors."""
        return {k for k, cell in enumerate(self.loop.carried) if cell.input in self.wide}

    def text(self) -> list[str]:
        """The loop, to the end of the record, and its results."""
        return [*self.before(), *self.over([]), *self.after()]

    def until(self, zero: Sequence[int]) -> list[str]:
        """The loop, up to the sample before which these carried numbers are zero."""
        wide, open_ = self.carried_wide, ["    bool open = false;"]
        each = f"for (int j = 0; j < {self.count}; j++) "
        for k in zero:
            text = f"{each}open |= S{k}[j] != 0.0;" if k in wide else f"open |= S{k} != 0.0;"
            open_.append(f"    {text}")
        return [*self.before(), *self.over([*open_, "    if (!open) break;"])]

    def over(self, first: list[str], end: str = "n") -> list[str]:
        """The samples up to one, with statements at the begin of each."""
        lines = (f"    {line}" for line in (*first, *self._sample()))
        return [f"    for (; i < {end}; i++, u += width) {{", *lines, "    }"]

    def before(self, *, starts_only: bool = False) -> list[str]:
        """The code of parameters, of values that follow from them, and of the initial state."""
        self.scalars.lines = []
        for k, (_, number) in self._inputs("before"):
            self.scalars.names[k] = f"F{number}"
            self.scalars.lines.append(f"    const {self.type(k)} F{number} = S{number};")
        for k, value in self._inputs("p", "dp"):
            self._load(k, value)
        carried = self.loop.carried
        for number, cell in enumerate(carried):
            self.scalars.names[cell.input] = f"s{number}"
        asked = [cell.start for cell in carried]
        if not starts_only:
            asked += [cell.after for cell in carried]
            asked += [k for row in (*self.loop.kept, *self.loop.total) for k in row]
        self._statements(asked, steady=True)
        for n, cell in enumerate(carried):
            text = self._of_type(cell.input, cell.start)
            self.scalars.lines.append(f"    {self.type(cell.input)} {self.cells}{n} = {text};")
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
            self.scalars.lines.append(f"    const {self.type(cell.input)} s{n} = {self.cells}{n};")
        rows = [k for row in self.loop.kept for k in row]
        self._statements([*(cell.after for cell in carried), *rows], steady=False)
        for n, cell in enumerate(carried):
            text = self._of_type(cell.input, cell.after)
            self.scalars.lines.append(f"    {self.cells}{n} = {text};")
        for row in self.loop.kept:
            self._put(row, "kept")
        return self.scalars.lines

    def after(self) -> list[str]:
        """The code after the last sample."""
        self.scalars.lines = []
        for n, cell in enumerate(self.loop.carried):
            self.scalars.names[cell.input] = f"{self.cells}{n}"
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
            self.scalars.lines.append(f"    const {self.type(k)} {name} = {cast}{group}[{number}];")
            return
        block = number * self.loop.directions + direction[0] if direction else number
        self.scalars.lines.append(f"    lanes {name};")
        each = f"for (int j = 0; j < {self.count}; j++)"
        self.scalars.lines.append(f"    {each} {name}[j] = {group}[{block * self.count} + j];")

    def _statements(self, roots: Iterable[int], *, steady: bool) -> None:
        """Add statements for needed nodes: those that no sample changes, or the rest."""
        for k in self._ordered(list(roots), steady=steady):
            text = self.scalars.doubled(k) if k in self.wide else self.scalars.text(k)
            text = text or self._wide_text(k)
            self.scalars.names[k] = f"t{k}"
            self.scalars.lines.append(f"    const {self.type(k)} t{k} = {text};")

    def _ordered(self, roots: list[int], *, steady: bool) -> list[int]:
        """The nodes that have no name yet, in the order of their statements."""
        loop, names, nodes = self.loop, self.scalars.names, self.graph.nodes
        deep = self.points or loop.operations > LONG
        every = _depth_first(self.graph, roots) if deep else self.graph.reached(roots)
        known = ("constant", "input")
        rest = [k for k in every if k not in names and nodes[k].op not in known]
        found = [k for k in rest if (k in self.steady) == steady]
        if deep or steady or not self._in_order:
            return found
        ends = [k for row in loop.kept for k in row]
        return scheduled(self.graph, found, [(c.input, c.after) for c in loop.carried], ends)

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

    def type(self, k: int) -> str:
        """The type of a node."""
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
