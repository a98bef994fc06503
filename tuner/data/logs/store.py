"""Columns of numbers as they come in, block by block."""

from collections.abc import Mapping, Sequence

import numpy as np

from tuner.data.logs.scaling import Floats
from tuner.data.logs.table import Raw
from tuner.limits import check_amount


class Store:
    """Columns that grow; whole numbers that float64 would round are kept as such.

    Args:
        size: bytes of the file, for an estimate of its rows.
        width: number of columns.
    """

    def __init__(self, size: int, width: int) -> None:
        self._size = size
        self._rows = 0
        self._values: list[Floats] = [np.empty(0) for _ in range(width)]
        self._whole: list[list[tuple[int, Raw]]] = [[] for _ in range(width)]

    def add(self, values: Sequence[Floats], whole: Mapping[int, Raw], text: int) -> None:
        """Add rows.

        Args:
            values: the numbers of each column.
            whole: the same as integers, of columns where that makes a difference.
            text: their size as text, in bytes.
        """
        if not values or not len(values[0]):
            return
        rows = self._rows + len(values[0])
        for k, column in enumerate(values):
            if rows > len(self._values[k]):
                self._grow(k, rows, len(column) / max(text, 1))
            self._values[k][self._rows : rows] = column
        for k, exact in whole.items():
            self._whole[k].append((self._rows, exact))
        self._rows = rows

    def columns(self) -> list[Raw]:
        """All columns: integers where all of one are whole and some would be rounded."""
        found: list[Raw] = []
        for values, whole in zip(self._values, self._whole, strict=True):
            column: Raw = values[: self._rows]
            if whole and (column == np.trunc(column)).all():
                column = column.astype(np.int64)
                for start, exact in whole:
                    column[start : start + len(exact)] = exact
            found.append(column)
        return found

    def _grow(self, k: int, rows: int, density: float) -> None:
        """Make room, for the whole file at first; memory that is not written costs nothing."""
        check_amount(
            f"{rows} rows of {len(self._values)} columns",
            8 * rows * len(self._values),
            "map fewer columns or cut the log into parts",
        )
        room = rows + rows // 4 if self._rows else max(rows, int(1.05 * density * self._size))
        bigger = np.empty(room)
        bigger[: self._rows] = self._values[k][: self._rows]
        self._values[k] = bigger
