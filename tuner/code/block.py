"""C statements with loops, and their buffers, which are reused where possible."""

import math
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from tuner.code.filled_rows import DENSE, FilledRows
from tuner.code.flat import wrapped
from tuner.code.literal import literal, type_of
from tuner.code.memory import Held, Index, Lazy, Listed, View, view
from tuner.code.names import in_comment
from tuner.code.operations import Kind
from tuner.code.source import Assignment, assignment
from tuner.code.tables import Tables

_SIMPLE = re.compile(r"-?[\w.>+*\[\] -]+|\(-[\w.]+\)")


class Block:
    """The body of a function under construction.

    Args:
        tables: constant arrays.
        spare: memory that may be reused when its content is no longer needed, with its size.
        rows: how its own arrays lie in memory.
    """

    def __init__(
        self,
        tables: Tables,
        spare: dict[str, tuple[int, Kind]],
        rows: FilledRows = DENSE,
    ) -> None:
        self.tables, self.precision, self.rows = tables, tables.precision, rows
        self.lines: list[str] = []
        self.locals: dict[str, tuple[int, Kind]] = {}
        self.depth, self._names = 1, 0
        self._origin: Assignment | None = None
        self._spare = spare
        self._free: set[str] = set()

    def say(self, text: str) -> None:
        """Add a statement."""
        self.lines.append(wrapped("    " * self.depth + text))

    def comment(self, source: Any, line: int) -> None:
        """Add a comment with the origin of the statements from a line on."""
        origin = assignment(source)
        if origin is not None and len(self.lines) > line and origin != self._origin:
            self._origin = origin
            words = in_comment(f"{origin.where}: {origin.text}", 110)
            self.lines[line:line] = ["", "    " * self.depth + f"/* {words} */"]

    def fresh(self, stem: str) -> str:
        """An unused name."""
        self._names += 1
        return f"{stem}{self._names}"

    def number(self, value: object, kind: Kind) -> str:
        """A number as an operand."""
        text = literal(value, kind, self.precision)
        return f"({text})" if text.startswith(("-", "(")) else text

    # Memory

    def buffer(self, shape: Sequence[int], kind: Kind, *, dense: bool = False) -> View:
        """Memory for an array: a free buffer, or a new one.

        Args:
            shape: of the array.
            kind: of its entries.
            dense: whether each entry is next to the one before it.
        """
        shape = tuple(shape)
        size = math.prod(shape) if dense else self.rows.size(shape)
        fits = [
            name
            for name in sorted(self._free)
            if self._kept[name][1] == kind and self._kept[name][0] >= size
        ]
        if fits:
            name = min(fits, key=lambda one: (self._kept[one][0], one))
            self._free.discard(name)
        else:
            name = self.fresh("m")
            self.locals[name] = (size, kind)
        return view(name, shape, kind) if dense else self.rows.view(name, shape, kind)

    @property
    def _kept(self) -> dict[str, tuple[int, Kind]]:
        return self.locals | self._spare

    def release(self, alive: Iterable[str]) -> None:
        """Free all memory that is not alive."""
        self._free = set(self._kept) - set(alive)

    def keep_spare(self) -> None:
        """Reserve memory that is not the function's own for results."""
        self._free -= set(self._spare)

    # Loops

    def nest(
        self, shape: Sequence[int], body: Callable[[list[int | str]], None], outer: Index = ()
    ) -> None:
        """Add loops around statements, which receive the index, beginning with an outer one."""
        if len(outer) == len(shape):
            body([*outer])
        elif shape[len(outer)] == 1:
            self.nest(shape, body, (*outer, 0))
        else:
            size = shape[len(outer)]
            self.loop(0, size, lambda name: self.nest(shape, body, (*outer, name)))

    def loop(self, first: int, end: int | str, body: Callable[[str], None]) -> None:
        """Add a loop around statements, which receive its variable."""
        name = f"i{self.depth}"
        self.say(f"for (int {name} = {first}; {name} < {end}; {name}++) {{")
        self.depth += 1
        body(name)
        self.depth -= 1
        self.say("}")

    def put(self, x: Held, into: View) -> None:
        """Write entries to memory."""
        self.nest(x.shape, lambda index: self.say(f"{into.at(index)} = {x.at(index)};"))

    def put_listed(self, x: Listed, into: View) -> None:
        """Write entries that are variables to memory."""
        for index in np.ndindex(x.shape):
            self.say(f"{into.at(index)} = {x.texts[index]};")

    def made(self, x: Held, dying: Iterable[str] = ()) -> View:
        """The array in memory: where it is, or in place of one that is no longer needed.

        Args:
            x: the array.
            dying: memory that only this one needs.
        """
        if isinstance(x, View):
            return x
        if not x.shape:
            name = self.fresh("t")
            self.say(f"const {type_of(x.kind, self.precision)} {name} = {x.at([])};")
            return View(name, (), x.kind, alone=True)
        begun, depth = len(self.lines), self.depth
        found: list[tuple[list[int | str], str]] = []
        self.nest(x.shape, lambda index: found.append((list(index), x.at(index))))
        (index, text), lines = found[0], self.lines[begun:]
        into = self._in_place(x, index, "\n".join([*lines, text]), dying)
        if into is not None and text == into.at(index):  # it is there already
            del self.lines[begun:]
            return into
        into = self.buffer(x.shape, x.kind) if into is None else into
        closing = sum(size != 1 for size in x.shape)
        at = len(self.lines) - closing
        self.lines.insert(at, wrapped("    " * (depth + closing) + f"{into.at(index)} = {text};"))
        self.fill_up(begun + closing - 1, into)
        return into

    def fill_up(self, line: int, into: View) -> None:
        """Let the loop along rows go on to where they are filled up to, where it may.

        Args:
            line: the number of its first line; its statements are the last ones so far.
            into: what it writes.
        """
        if into.strides != self.rows.view("", into.shape, into.kind).strides:
            return
        found = self.rows.longer(self.lines[line:], {*self.locals, *self.tables.names})
        if found is not None:
            self.lines[line], beyond = found
            self.tables.beyond = max(self.tables.beyond, beyond)

    def _in_place(self, x: Lazy, index: Index, text: str, dying: Iterable[str]) -> View | None:
        """Memory that is only read where it would be written."""
        for name in sorted(set(dying) & set(self._kept) & x.buffers):
            size, kind = self._kept[name]
            into = self.rows.view(name, x.shape, kind)
            read = set(re.findall(rf"(?<![\w>]){re.escape(name)}\[[^\]]*\]", text))
            if kind == x.kind and size >= self.rows.size(x.shape) and read == {into.at(index)}:
                return into
        return None

    def simple(self, text: str, kind: Kind) -> str:
        """An operand that may be repeated, and is evaluated whether it is used or not."""
        if _SIMPLE.fullmatch(text):
            return text
        name = self.fresh("e")
        self.say(f"const {type_of(kind, self.precision)} {name} = {text};")
        return name
