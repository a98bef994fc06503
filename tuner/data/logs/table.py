"""A log file as every format presents it: named raw columns that load on demand."""

from collections.abc import Callable, Sequence
from collections.abc import Mapping as Named
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.blocks import Blocks
from tuner.data.logs.error import FEW, LogError, suggest
from tuner.data.logs.mapping import Mapped, Mapping

Raw = NDArray[Any]
Floats = NDArray[np.float64]


def array_row(row: int) -> str:
    """The place of a row of an array; the text says that it counts from 0."""
    return f"row {row} (counted from 0)"


@dataclass(frozen=True)
class Loaded:
    """Columns as they were read.

    Attributes:
        raw: the arrays by name.
        notes: remarks on the reading, a sentence each.
    """

    raw: dict[str, Raw]
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, found: "dict[str, Raw] | Loaded") -> "Loaded":
        """The result of a table's loading, in this form."""
        return found if isinstance(found, Loaded) else cls(found)


@dataclass(frozen=True)
class Table:
    """The columns of one file before anything is mapped.

    Attributes:
        file: name of the file without its folder, for messages.
        names: the columns (and scalars) in the order of the file, each once.
        load: reads the named ones; scalars come as arrays of size 1. Notes on them come with
            them in a :class:`Loaded`.
        place: the place in the file of a row counted from 0: ``line 7``.
        numbered: columns may also be named by their number, from 1.
        texts: the columns that are known to hold text.
        labels: reads one column as text, ``(N,)`` of str, where the format can.
        moments: the columns that hold dates or times of day; they are loaded as bytes.
        kinds: the words that mark kinds of rows, each with the table of its rows.
        format: the kind of file, in words.
        groups: where the columns have several clocks, one table for each of them.
        prefix: the common prefix of all columns' names; it may be left out where a group is meant.
        time: the time column that the format itself prescribes, with its unit.
        units: the units that the file gives, by column.
        widths: count of numbers in a row of a column, where it is known and not one.
        rows: number of rows, where it is known.
        notes: remarks on the file, and assumptions.
        blocks: passes on what is read of the file, where its reader does.
    """

    file: str
    names: tuple[str, ...]
    load: Callable[[Sequence[str]], dict[str, Raw] | Loaded]
    place: Callable[[int], str] = array_row
    numbered: bool = False
    texts: frozenset[str] = frozenset()
    labels: Callable[[str], Raw] | None = None
    moments: frozenset[str] = frozenset()
    kinds: "Named[str, Callable[[], Table]]" = field(default_factory=dict)
    format: str = "text"
    groups: "tuple[Table, ...]" = ()
    prefix: str = ""
    time: Mapping | None = None
    units: Named[str, str] = field(default_factory=dict)
    widths: Named[str, int] = field(default_factory=dict)
    rows: int | None = None
    notes: tuple[str, ...] = ()
    blocks: Blocks | None = None

    def find(self, mapping: Mapping) -> Mapping | None:
        """The mapping with its column as the file names it; None where there is none.

        An exact name goes before its parts: ``gyro[2]`` may be a column of that name.
        """
        column, unit, minus = mapping.column, mapping.unit, "-" * mapping.minus
        index = "" if mapping.index is None else f"[{mapping.index}]"
        if minus + column + index in self.names:
            return replace(mapping, column=minus + column + index, index=None, minus=False)
        if column + index in self.names:
            return replace(mapping, column=column + index, index=None)
        if f"{mapping.source}:{unit}" in self.names:
            return Mapping(mapping.channel, f"{mapping.source}:{unit}")
        if column in self.names:
            return mapping
        number = column.removeprefix(self.prefix)
        if self.numbered and number.isdecimal() and 0 < int(number) <= len(self.names):
            return replace(mapping, column=self.names[int(number) - 1])
        return self._find_shorter(mapping)

    def _find_shorter(self, mapping: Mapping) -> Mapping | None:
        """The table of a group: its columns by their numbers, or without its prefix."""
        column = mapping.column
        if self.prefix and not column.startswith(self.prefix):
            return self.find(replace(mapping, column=self.prefix + column))
        numbered = (g for g in self.groups if g.numbered and column.startswith(g.prefix))
        return next((group.find(mapping) for group in numbered), None)

    def with_kinds(self, columns: Sequence[str]) -> "Table":
        """The table with a group for each word in ``WORD/NAME``, one of these columns."""
        words = dict.fromkeys(column.partition("/")[0] for column in columns if "/" in column)
        tables = [self.kinds[word]() for word in words if word in self.kinds]
        return together(self.file, [self, *tables], self.format, self.notes) if tables else self

    def resolve(self, mapping: Mapping) -> Mapping:
        """The mapping with its column as the file names it.

        Raises:
            LogError: where there is no such column.
        """
        found = self.find(mapping)
        if found is None:
            way_out = suggest(mapping.column, self.names)
            more = "; tuner columns FILE lists all" * (len(self.names) > FEW)
            raise LogError(f"{self.file}: there is no column {mapping.column!r}; {way_out}{more}")
        return found

    def find_parts(self, mapped: Mapped) -> tuple[Mapping, ...] | None:
        """All columns of a channel as the file names them; None where one is missing."""
        name, _, unit = mapped.text.rpartition(":")
        if len(mapped.parts) > 1 and mapped.text in self.names:
            return (Mapping(mapped.channel, mapped.text),)
        if len(mapped.parts) > 1 and "," in name and name in self.names:
            return (Mapping(mapped.channel, name, unit=unit.strip()),)
        found = [self.find(part) for part in mapped.parts]
        return None if None in found else tuple(part for part in found if part is not None)


def together(file: str, tables: Sequence[Table], kind: str, notes: tuple[str, ...] = ()) -> Table:
    """One table of several that have prefixes and clocks of their own."""
    owners = {name: table for table in tables for name in table.names}

    def load(names: Sequence[str]) -> Loaded:
        parts = [(t, [name for name in names if owners[name] is t]) for t in tables]
        found = [Loaded.of(table.load(own)) for table, own in parts if own]
        raw = {name: column for part in found for name, column in part.raw.items()}
        return Loaded(raw, tuple(note for part in found for note in part.notes))

    return Table(file, tuple(owners), load, format=kind, groups=tuple(tables), notes=notes)
