"""A log file as every format presents it: named raw columns that load on demand."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.error import LogError, suggest
from tuner.data.logs.mapping import Mapping

Raw = NDArray[Any]
Floats = NDArray[np.float64]


def array_row(row: int) -> str:
    """Where a row of an array is: numpy counts from 0, other tools from 1, so it is said."""
    return f"row {row} (counted from 0)"


@dataclass(frozen=True)
class Table:
    """The columns of one file before anything is mapped.

    Attributes:
        file: name of the file without its folder, for the sentences.
        names: the columns (and scalars) in the order of the file, each once.
        load: reads the named ones; scalars come as arrays of size 1.
        place: where a row, counted from 0, stands in the file: ``line 7``.
        numbered: columns may also be named by their number, from 1.
        texts: the columns that are known to hold text.
    """

    file: str
    names: tuple[str, ...]
    load: Callable[[Sequence[str]], dict[str, Raw]]
    place: Callable[[int], str] = array_row
    numbered: bool = False
    texts: frozenset[str] = frozenset()

    def resolve(self, mapping: Mapping) -> Mapping:
        """The mapping with its column as the file names it.

        Raises:
            LogError: where there is no such column.
        """
        column = mapping.column
        if column in self.names:
            return mapping
        if self.numbered and column.isdecimal() and 0 < int(column) <= len(self.names):
            return replace(mapping, column=self.names[int(column) - 1])
        way_out = suggest(column, self.names)
        raise LogError(f"{self.file}: there is no column {column!r}; {way_out}")
