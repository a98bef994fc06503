"""A block of lines of a text log as cells: without blanks, quotes, comments and repeated heads."""

import csv
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tuner.data.logs.cells import is_missing, read_cell
from tuner.data.logs.error import LogError
from tuner.data.logs.grid import Grid, find_cells
from tuner.data.logs.layout import Layout
from tuner.data.logs.moments import is_moment
from tuner.names import counted

INSIDE = "\x1f"
"""The substitute for a delimiter inside quotes."""

_QUOTE, _TAB, _BLANK, _NEWLINE = b'"\t \n'


@dataclass(frozen=True)
class Block:
    """Whole lines of a text log, below its names.

    Attributes:
        text: the lines.
        line: the number in the file of the first, from 1.
        last: whether the file ends here.
    """

    text: bytes
    line: int
    last: bool = False


@dataclass(frozen=True, eq=False)
class Rows:
    """The rows of a block.

    Attributes:
        grid: their cells.
        lines: their numbers in the file.
        left_out: the reasons why other lines were left out, with a count each.
    """

    grid: Grid
    lines: Sequence[int]
    left_out: Mapping[str, int]


def read_rows(layout: Layout, block: Block) -> Rows:
    """The rows of a block.

    Raises:
        LogError: for a line of another width that is neither a repeated head nor the last.
    """
    text, cut = block.text, not block.text.endswith(b"\n")
    text = tidied(layout, text + b"\n" * cut)
    if not cut and layout.chosen is None:
        grid = _cells(layout, text)
        if grid is not None and not _may_be_no_rows(layout, grid):
            return Rows(grid, range(block.line, block.line + len(grid)), {})
    kept, left_out = _kept(layout, block, text[:-1].split(b"\n"), cut)
    grid = _cells(layout, b"".join(line + b"\n" for _, line in kept))
    if grid is None:
        raise LogError(f"{layout.path.name}: the lines from {block.line} on cannot be taken apart")
    return Rows(grid, [block.line + number for number, _ in kept], left_out)


def tidied(layout: Layout, text: bytes) -> bytes:
    """Whole lines without blanks beside delimiters and without quotes; a line stays a line."""
    if b'"' in text:
        text = _unquoted(layout, text)
    return _trimmed(text, layout.delimiter) if b" " in text or b"\t" in text else text


def _cells(layout: Layout, text: bytes) -> Grid | None:
    quoted_comma = layout.point == layout.delimiter == ","
    point = INSIDE if quoted_comma else layout.point
    return find_cells(text, layout.delimiter or " ", len(layout.names), point)


def _trimmed(text: bytes, delimiter: str | None) -> bytes:
    """Lines without blanks at the ends of cells, and with single blanks inside them."""
    letters = np.frombuffer(text, np.uint8)
    blank = letters == _BLANK
    border = letters == _NEWLINE
    if delimiter != "\t":
        blank |= letters == _TAB
    if delimiter is not None:
        border |= letters == ord(delimiter)
    solid = np.flatnonzero(~blank)
    between = np.flatnonzero(np.diff(solid) > 1)
    left, right = solid[between], solid[between + 1]
    inside = left[~(border[left] | border[right])] + 1
    blank[inside] = False
    found = letters.copy()
    found[inside] = _BLANK
    return bytes(found[~blank])


def _unquoted(layout: Layout, text: bytes) -> bytes:
    """Lines without quotes; delimiters inside quotes become ``INSIDE``."""
    delimiter = ord(layout.delimiter or " ")
    letters = np.frombuffer(text, np.uint8)
    quote = letters == _QUOTE
    inside = (np.cumsum(quote, dtype=np.uint8) & 1).astype(bool)
    if inside[letters == _NEWLINE].any():
        lines = text.decode("latin-1").split("\n")
        return "\n".join(_line_unquoted(line, chr(delimiter)) for line in lines).encode("latin-1")
    found = np.where(inside & (letters == delimiter), ord(INSIDE), letters).astype(np.uint8)
    return bytes(found[~quote])


def _line_unquoted(line: str, delimiter: str) -> str:
    cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    return delimiter.join(cell.replace(delimiter, INSIDE) for cell in cells)


def _may_be_no_rows(layout: Layout, grid: Grid) -> bool:
    """Whether some lines may be comments, repeated heads or blank."""
    first = grid.text[grid.spans.starts[:, 0]]
    marks = {*b"#%", *(head[0] for head in layout.heads if head)}
    if len(layout.names) == 1:
        marks.add(_NEWLINE)
    return bool(np.isin(first, list(marks)).any())


def _kept(
    layout: Layout, block: Block, lines: list[bytes], cut: bool
) -> tuple[list[tuple[int, bytes]], Mapping[str, int]]:
    """The lines that are rows, each with its number in the block, and what was left out."""
    left_out: Counter[str] = Counter()
    rows: list[tuple[int, bytes]] = []
    others: list[tuple[int, bytes]] = []
    for number, line in enumerate(lines):
        if not line or line[:1] in b"#%":
            continue
        if line in layout.heads:
            left_out["repeated head"] += 1
            continue
        cells = _parted(layout, line)
        if layout.chosen is None or layout.chosen.holds(cells):
            unfinished = cut and number == len(lines) - 1 and not _complete(layout, cells)
            fits = len(cells) == len(layout.names) and not unfinished
            (rows if fits else others).append((number, line))
    behind = rows[-1][0] if rows else -1
    for number, line in others:
        final = block.last and number > behind
        reason = _why_no_row(layout, line, number == len(lines) - 1) if final else ""
        if not reason:
            raise _ragged(layout, block.line + number, line)
        left_out[reason] += 1
    return rows, left_out


def _parted(layout: Layout, line: bytes) -> list[str]:
    text = line.decode(layout.encoding.letters, "replace")
    return text.split(layout.delimiter or " ")


def _complete(layout: Layout, cells: list[str]) -> bool:
    """Whether the cells of an unfinished last line are complete."""
    pairs = zip(layout.names, cells, strict=False)
    return all(name in layout.texts or _is_value(layout, cell) for name, cell in pairs)


def _is_value(layout: Layout, cell: str) -> bool:
    return is_missing(cell) or read_cell(cell, layout.point) is not None or is_moment(cell)


def _why_no_row(layout: Layout, line: bytes, last: bool) -> str:
    """The reason to leave out a line below all rows; "" where there is none."""
    cells = _parted(layout, line)
    if not any(read_cell(cell, layout.point) for cell in cells if not is_missing(cell)):
        return "line without a number at the end"
    return "cut last line" if last and len(cells) <= len(layout.names) else ""


def _ragged(layout: Layout, line: int, text: bytes) -> LogError:
    """The message about a line that is not a row."""
    cells, width = _parted(layout, text), len(layout.names)
    return LogError(
        f"{layout.path.name}: line {line} has {counted(len(cells), 'cell')} instead of {width}; "
        f"complete the line or remove it"
    )
