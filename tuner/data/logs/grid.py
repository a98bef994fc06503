"""Places of the cells of a text, found by its delimiters all at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.decimals import MARGIN, Numbers, Spans, read_decimals
from tuner.data.logs.scaling import Index

_NEWLINE, _SMALL = ord("\n"), 0x20
_ROUNDED, _TOP = np.uint64(1 << 53), np.uint64(1 << 63)
_SHORT = 9  # with a sign
_BEFORE = b"\n" * MARGIN


@dataclass(frozen=True, eq=False)
class Grid:
    """Lines of a text that have the same number of cells.

    Attributes:
        text: the characters, with a margin at both ends.
        spans: where the cells lie, ``(rows, width)``.
    """

    text: NDArray[np.uint8]
    spans: Spans

    def __len__(self) -> int:
        return len(self.spans.starts)

    def cells(self, column: int) -> list[bytes]:
        """One column as text."""
        return self._written(self.spans.starts[:, column], self.spans.ends[:, column])

    def chosen(self, columns: Sequence[int], places: Index) -> list[bytes]:
        """Some cells as they are written, by their places among the numbers of some columns."""
        row, column = np.divmod(places, max(len(columns), 1))
        at = row, np.array(columns, np.intp)[column]
        return self._written(self.spans.starts[at], self.spans.ends[at])

    def whole(self, columns: Sequence[int], numbers: Numbers) -> dict[int, NDArray[np.int64]]:
        """Columns of whole numbers of which float64 rounds some, by their places, ``(rows,)``."""
        shape = (len(self), max(len(columns), 1))
        digits, negative = numbers.whole.reshape(shape), numbers.negative.reshape(shape)
        found = {}
        for k in np.flatnonzero((digits > _ROUNDED).any(axis=0)).tolist():
            plain = self.spans.points[:, columns[k]] == self.spans.ends[:, columns[k]]
            filled = np.isfinite(numbers.values.reshape(shape)[:, k])
            if plain.all() and filled.all() and digits[:, k].max() < _TOP:
                sign = 1 - 2 * negative[:, k].astype(np.int64)
                found[k] = sign * digits[:, k].astype(np.int64)
        return found

    def _written(self, starts: Index, ends: Index) -> list[bytes]:
        if not len(starts):
            return []
        whole = self.text.tobytes()
        return [whole[a:b] for a, b in zip(starts.tolist(), ends.tolist(), strict=True)]

    def numbers(self, columns: Sequence[int]) -> Numbers:
        """Some columns as numbers, row by row, ``(rows * len(columns),)``.

        Columns of few characters are read apart from others, which take longer.
        """
        spans = self.spans.columns(columns)
        lengths = (spans.stops - spans.starts).reshape(-1, max(len(columns), 1))
        short = lengths.max(axis=0, initial=0) <= _SHORT
        if short.all() or not short.any():
            return read_decimals(self.text, spans)
        kinds = [np.flatnonzero(kind).tolist() for kind in (short, ~short)]
        parts = [spans.shaped(len(columns)).columns(kind) for kind in kinds]
        return _woven([read_decimals(self.text, part) for part in parts], kinds)


def _woven(parts: Sequence[Numbers], kinds: Sequence[list[int]]) -> Numbers:
    """Numbers of some columns and of others as those of all, row by row."""
    width = sum(map(len, kinds))
    rows = len(parts[0].values) // len(kinds[0])
    values, whole = np.empty((rows, width)), np.empty((rows, width), np.uint64)
    negative = np.empty((rows, width), bool)
    odd = []
    for part, columns in zip(parts, kinds, strict=True):
        shape = (rows, len(columns))
        values[:, columns] = part.values.reshape(shape)
        whole[:, columns] = part.whole.reshape(shape)
        negative[:, columns] = part.negative.reshape(shape)
        row, column = np.divmod(part.odd, len(columns))
        odd.append(row * width + np.array(columns)[column])
    return Numbers(values.ravel(), whole.ravel(), negative.ravel(), np.sort(np.concatenate(odd)))


def find_cells(block: bytes, delimiter: str, width: int, point: str) -> Grid | None:
    """The cells of whole lines; None where a line has another number of them.

    >>> grid = find_cells(b"1,2\\n3,4.5\\n", ",", 2, ".")
    >>> grid.cells(1), grid.numbers([1]).values.tolist()
    ([b'2', b'4.5'], [2.0, 4.5])
    """
    text = np.frombuffer(_BEFORE + block + bytes(8 + -len(block) % 8), np.uint8)
    mark = text == ord(delimiter)
    mark |= text == _NEWLINE
    mark |= text == ord(point)
    if b"e" in block or b"E" in block:
        mark |= (text | _SMALL) == ord("e")
    marks = np.flatnonzero(mark)
    kinds = text.take(marks)
    dot = kinds == ord(point)
    border = (kinds == ord(delimiter)) | (kinds == _NEWLINE)
    places = np.flatnonzero(border)
    closing = (kinds.take(places) == _NEWLINE)[MARGIN:]
    if len(closing) % width:
        return None
    closing = closing.reshape(-1, width)
    if not closing[:, -1].all() or np.count_nonzero(closing) != len(closing):
        return None
    spans = _plain_spans if len(places) + np.count_nonzero(dot) == len(marks) else _spans
    return Grid(text, spans(marks, dot, border, places).shaped(width))


def _plain_spans(
    marks: Index, dot: NDArray[np.bool_], border: NDArray[np.bool_], places: Index
) -> Spans:
    """The parts of each cell where none has an exponent."""
    last = marks.take(places)
    starts, ends = last[MARGIN - 1 : -1] + 1, last[MARGIN:]
    before = places[MARGIN:] - 1
    points = marks.take(before)
    dotted = dot.take(before)
    np.copyto(points, ends, where=~dotted)
    odd = np.zeros(len(ends), bool)
    if (dot[1:] & dot[:-1]).any():
        odd = dotted & dot.take(before - 1)
    return Spans(starts, points, ends, ends, odd)


def _spans(marks: Index, dot: NDArray[np.bool_], border: NDArray[np.bool_], places: Index) -> Spans:
    """The parts of each cell by the marks before its end: a point, an exponent, both or none."""
    last = marks.take(places)
    starts, ends = last[MARGIN - 1 : -1] + 1, last[MARGIN:]
    before = places[MARGIN:] - 1
    raised = ~(dot | border).take(before)
    stops = np.where(raised, marks.take(before), ends)
    before -= raised
    dotted = dot.take(before)
    points = np.where(dotted, marks.take(before), stops)
    odd = ~border.take(before - dotted)
    return Spans(starts, points, stops, ends, odd)
