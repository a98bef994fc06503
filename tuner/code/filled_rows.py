"""Rows of arrays that are filled up in memory, so that whole vectors are computed and stored."""

import math
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from tuner.code.memory import View, view
from tuner.code.operations import Kind

_SHORT = 8
"""Entries up to which a row is not filled up."""
_LOOP = re.compile(r" *for \(int (?P<name>\w+) = 0; (?P=name) < (?P<size>\d+); ")
_ENTRY = re.compile(r"([\w.>-]+)\[([^\]]*)\]")


@dataclass(frozen=True)
class FilledRows:
    """How arrays lie in memory.

    Attributes:
        lanes: entries of a vector: to a multiple of it rows are filled up that end in the second
            half of one; 1: none is.
    """

    lanes: int

    def row(self, size: int) -> int:
        """The entries of a row, with those that fill it up.

        >>> [FilledRows(4).row(size) for size in (7, 13, 14, 15, 16)]
        [7, 13, 16, 16, 16]
        """
        whole = -(-size // self.lanes) * self.lanes
        return whole if size > _SHORT and whole - size <= self.lanes // 2 else size

    def size(self, shape: Sequence[int]) -> int:
        """The entries of an array."""
        filled = 0 < len(shape) < 3
        return math.prod(shape[:-1]) * self.row(shape[-1]) if filled else math.prod(shape)

    def view(self, name: str, shape: tuple[int, ...], kind: Kind) -> View:
        """All of some memory."""
        if len(shape) != 2:
            return view(name, shape, kind)
        return View(name, shape, kind, 0, (self.row(shape[1]), 1))

    def longer(self, lines: Sequence[str], own: Collection[str]) -> tuple[str, int] | None:
        """A loop along rows that goes on to where they are filled up to.

        Args:
            lines: of the loop, and all that is in it.
            own: memory that may be read behind its last entry.

        Returns:
            Its first line, and how many entries it may read behind the last one of an array; None
            where it reads other memory along rows, or its own across them.
        """
        found = _LOOP.match(lines[0])
        if found is None:
            return None
        column, size = found["name"], int(found["size"])
        for name, index in _ENTRY.findall("\n".join(lines[1:])):
            across = re.search(rf"\[|\* \(?{column}\b", index)
            if re.search(rf"\b{column}\b", index) and (across or name not in own):
                return None
        row = self.row(size)
        return lines[0].replace(f"{column} < {size};", f"{column} < {row};"), row - size


DENSE = FilledRows(1)
"""No row is filled up."""
