"""Where the cells of a text lie: found by its delimiters, all at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.decimals import MARGIN, Numbers, Spans, read_decimals
from tuner.data.logs.scaling import Index

_NEWLINE = ord("\n")
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

    def cell(self, row: int, column: int) -> bytes:
        """One cell as it is written."""
        start, end = self.spans.starts[row, column], self.spans.ends[row, column]
        return self.text[start:end].tobytes()

    def cells(self, column: int) -> list[bytes]:
        """One column as it is written."""
        whole = self.text.tobytes()
        starts, ends = self.spans.starts[:, column], self.spans.ends[:, column]
        return [whole[a:b] for a, b in zip(starts.tolist(), ends.tolist(), strict=True)]

    def numbers(self, columns: Sequence[int]) -> Numbers:
        """Some columns as numbers, row by row, ``(rows * len(columns),)``."""
        return read_decimals(self.text, self.spans.columns(columns))


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
    for letter in b"eE":
        if letter in block:
            mark |= text == letter
    marks = np.flatnonzero(mark)
    kinds = text[marks]
    border = (kinds == ord(delimiter)) | (kinds == _NEWLINE)
    places = np.flatnonzero(border)
    closing = (kinds[places] == _NEWLINE)[MARGIN:]
    if len(closing) % width:
        return None
    closing = closing.reshape(-1, width)
    if not closing[:, -1].all() or closing.sum() != len(closing):
        return None
    spans = _spans(marks, kinds == ord(point), border, places)
    return Grid(text, spans.shaped(width))


def _spans(marks: Index, dot: NDArray[np.bool_], border: NDArray[np.bool_], places: Index) -> Spans:
    """The parts of each cell by the marks before its end: a point, an exponent, both or none."""
    last = marks.take(places)
    starts, ends = last[MARGIN - 1 : -1] + 1, last[MARGIN:]
    before = places[MARGIN:] - 1
    stops = ends
    raised = np.flatnonzero(~(dot | border).take(before))
    if len(raised):
        stops = ends.copy()
        stops[raised] = marks[before[raised]]
        before[raised] -= 1
    dotted = dot.take(before)
    points = marks.take(before)
    np.copyto(points, stops, where=~dotted)
    before -= dotted
    return Spans(starts, points, stops, ends, ~border.take(before))
