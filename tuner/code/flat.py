"""Nodes as statements, with variables for repeated nodes and those named in the source."""

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from itertools import count
from typing import Any

from tuner.code.expression import Expressions
from tuner.code.graph import Graph
from tuner.code.literal import Precision, type_of
from tuner.code.names import identifier, in_comment
from tuner.code.program import Label
from tuner.code.source import Assignment, assignment

_LONGEST = 26
_WIDTH = 100


class Statements:
    """Statements for nodes of a graph, in one function.

    Args:
        graph: of the nodes.
        labels: where nodes were traced.
        precision: of real numbers.
        input: an input's name in this function.
        given: names of nodes that are already computed.
        stem: prefix of variables without a name in the source.
    """

    def __init__(
        self,
        graph: Graph,
        labels: dict[int, list[Label]],
        precision: Precision,
        input: Callable[[Any], str],
        given: dict[int, str] | None = None,
        stem: str = "t",
    ) -> None:
        self.graph, self.labels, self.precision = graph, labels, precision
        self.names: dict[int, str] = dict(given or {})
        self.expressions = Expressions(graph, precision, input, self.names)
        self.lines: list[str] = []
        self._taken, self._stem, self._numbers = set[str](), stem, count()
        self._turns: dict[tuple[str, int], str] = {}
        self._before: tuple[str, ...] = ()

    def add(self, roots: Iterable[int]) -> None:
        """Add statements that compute these nodes, each in a variable."""
        wanted = {k for k in roots if self.graph.nodes[k].op != "constant"}
        live = self._live(wanted)
        uses = Counter(k for entry in live for k in self.graph.nodes[entry].args)
        alone = {k for entry in live for k in self._whole(entry)}
        size: dict[int, int] = {}
        for entry in live:
            node = self.graph.nodes[entry]
            if node.op == "input":
                if entry in wanted and node.value[0] == "state":  # which is written to at the end
                    self._declare(entry, None)
                continue
            size[entry] = 1 + sum(size.get(k, 1) for k in node.args if k not in self.names)
            origin = self._name_source(entry) if entry in self.labels else None
            named = origin is not None and size[entry] > 2
            if uses[entry] > 1 or entry in wanted | alone or size[entry] > _LONGEST or named:
                self._declare(entry, origin)

    def _live(self, roots: Collection[int]) -> list[int]:
        """The entries that have yet to be computed."""
        seen, open_ = set[int](), list(roots)
        while open_:
            entry = open_.pop()
            if entry in seen or entry in self.names:
                continue
            seen.add(entry)
            open_ += self.graph.nodes[entry].args
        return sorted(k for k in seen if self.graph.nodes[k].op != "constant")

    def _whole(self, entry: int) -> tuple[int, ...]:
        """Operands that are computed beforehand.

        Both branches of a choice always are: every step takes the same time. Operands of the larger
        or the smaller of two numbers are written twice.
        """
        node = self.graph.nodes[entry]
        return {"choose": node.args[1:], "max": node.args, "min": node.args}.get(node.op, ())

    def _name_source(self, entry: int) -> tuple[Assignment, tuple[int, ...], int] | None:
        for source, index, number in self.labels[entry]:
            found = assignment(source)
            if found is not None:
                return found, index, number
        return None

    def _declare(self, entry: int, origin: tuple[Assignment, tuple[int, ...], int] | None) -> None:
        text = self.expressions.text(entry)
        node = self.graph.nodes[entry]
        if origin is not None and origin[0][1:] != self._before:
            self._before = origin[0][1:]
            words = in_comment(f"{origin[0].where}: {origin[0].text}", 110)
            self.lines += ["", f"    /* {words} */"]
        name = self._plain() if origin is None else self._named(*origin)
        self._taken.add(name)
        self.names[entry] = name
        type_ = type_of(node.kind, self.precision)
        self.lines.append(wrapped(f"    const {type_} {name} = {text};"))

    def _plain(self) -> str:
        return next(new for k in self._numbers if (new := f"{self._stem}{k}") not in self._taken)

    def _named(self, origin: Assignment, index: tuple[int, ...], number: int) -> str:
        """A name with the entry's index, and a further letter where it is repeated."""
        base = identifier(origin.name)
        if (base, number) not in self._turns:
            turn = sum(1 for name, _ in self._turns if name == base)
            self._turns[base, number] = _letters(turn)
        whole = "_".join((base.rstrip("_") or "a", *map(str, index))) if index else base
        stem = self._turns[base, number]
        return identifier(f"{whole}_{stem}" if stem else whole, self._taken)


def _letters(turn: int) -> str:
    """The suffix of a repeated name: none for the first, then b, c, ... z, ba and so on."""
    text = ""
    while turn:
        turn, rest = divmod(turn, 26)
        text = "abcdefghijklmnopqrstuvwxyz"[rest] + text
    return text


def wrapped(line: str, width: int = _WIDTH, before: str = r" (?=[-+*/?:] |\|\| |&& )") -> str:
    """A long statement broken before operators, or at another pattern."""
    parts, rest = [], line
    while len(rest) > width:
        breaks = re.finditer(before, rest[:width])
        at = max((found.start() for found in breaks if found.start() > 12), default=None)
        if at is None:
            break
        parts.append(rest[:at])
        rest = "        " + rest[at + 1 :]
    return "\n".join([*parts, rest])
