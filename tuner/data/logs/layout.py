"""How a text log is laid out: its lines, its delimiter and the names of its columns."""

import csv
import gzip
from codecs import getincrementaldecoder
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TextIO

from tuner.data.logs.error import LogError

_GZIP = b"\x1f\x8b"
_HEAD = 1 << 16
_PROBE = 12


@dataclass(frozen=True)
class Layout:
    """What is known of a text log before its numbers are read.

    Attributes:
        path: the file.
        delimiter: one character, or None where blanks separate the cells.
        names: the columns, each name once.
        above: how many lines of content stand above the numbers: titles and names.
        texts: the columns whose first cell is text.
        comma: whether the numbers have a decimal comma.
    """

    path: Path
    delimiter: str | None
    names: tuple[str, ...]
    above: int
    texts: frozenset[str]
    comma: bool = False


@contextmanager
def open_text(path: Path) -> Iterator[TextIO]:
    """The lines of a plain or gzip-compressed text file, without a byte order mark.

    What is no UTF-8 at its beginning is taken as cp1252, the usual one where it is not.
    """
    with path.open("rb") as stream:
        opener = gzip.open if stream.read(len(_GZIP)) == _GZIP else open
    with opener(path, "rb") as raw:
        encoding = _encoding(raw.read(_HEAD))
    with opener(path, "rt", encoding=encoding, errors="replace") as text:
        yield text


def _encoding(head: bytes) -> str:
    try:
        getincrementaldecoder("utf-8")().decode(head)  # a letter may be cut at the end
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"


def is_content(line: str) -> bool:
    """Whether a line is neither blank nor a comment; a tab alone may separate empty cells."""
    text = line.strip(" \r\n")
    return bool(text) and text[0] not in "#%"


def split(lines: Iterable[str], delimiter: str | None) -> Iterator[list[str]]:
    """The cells of each line."""
    if delimiter is None:
        return (line.split() for line in lines)
    return csv.reader(lines, delimiter=delimiter, skipinitialspace=True)


def is_number(cell: str) -> bool:
    """Whether a cell reads as a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def read_layout(path: Path) -> Layout:
    """Look at the first lines of a text log.

    Raises:
        LogError: where the file is no text or holds no numbers.
    """
    with open_text(path) as stream:
        if "\0" in stream.read(_HEAD):
            raise LogError(
                f"{path.name}: the file is neither UTF-8 text nor NPZ nor MAT; export it as CSV"
            )
    comment, lines = _first_lines(path)
    delimiter = _sniff(lines)
    rows = list(split(lines, delimiter))
    titles = _titles(rows)
    header = len(rows) > titles and _is_header(rows[titles])
    data = rows[titles + header :]
    if not data:
        raise LogError(f"{path.name}: there is not one row of numbers in it; record the log again")
    named = rows[titles] if header else _commented_names(comment, delimiter, len(data[0]))
    names = _unique(named)
    texts = (name for name, cell in zip(names, data[0], strict=False) if _is_text(cell))
    comma = delimiter != "," and _decimal_comma(data)
    return Layout(path, delimiter, names, titles + header, frozenset(texts), comma)


def _titles(rows: list[list[str]]) -> int:
    """How many rows of another width, without a number, stand above the names."""
    width = len(rows[-1]) if rows else 0
    for count, row in enumerate(rows):
        if len(row) == width or any(map(is_number, row)):
            return count
    return 0


def _decimal_comma(rows: list[list[str]]) -> bool:
    """Whether some cells are numbers with a comma, and none with a point."""
    cells = [cell for row in rows for cell in row if _reads_as_number(cell)]
    return any("," in cell for cell in cells) and not any("." in cell for cell in cells)


def _reads_as_number(cell: str) -> bool:
    return is_number(cell.replace(",", ".", 1))


def _first_lines(path: Path) -> tuple[str, list[str]]:
    """The last comment above the content, and the first lines of the content."""
    comment = ""
    with open_text(path) as stream:
        for line in stream:
            if is_content(line):
                return comment, [line, *islice(filter(is_content, stream), _PROBE)]
            comment = line.strip().lstrip("#%") or comment
    return comment, []


def _sniff(lines: list[str]) -> str | None:
    """The delimiter that most lines below the first hold; a decimal comma yields to it."""
    lines = lines[1:] or lines
    for delimiter in "\t;,":
        if 2 * sum(delimiter in line for line in lines) > len(lines):
            return delimiter
    return None


def _is_text(cell: str) -> bool:
    return bool(cell.strip()) and not is_number(cell.replace(",", "."))


def _is_header(cells: list[str]) -> bool:
    """A header holds text and not one number: a damaged first row must not pass for one."""
    return any(map(_is_text, cells)) and not any(map(is_number, cells))


def _commented_names(comment: str, delimiter: str | None, width: int) -> list[str]:
    """Names from the comment right above the numbers (as numpy.savetxt writes them)."""
    cells = next(split([comment], delimiter), []) if comment else []
    return cells if len(cells) == width and _is_header(cells) else [""] * width


def _unique(cells: list[str]) -> tuple[str, ...]:
    """Names without blanks around them; nameless and repeated ones tell their number."""
    names = [cell.strip() or f"column{number}" for number, cell in enumerate(cells, 1)]
    counts = Counter(names)
    return tuple(
        name if counts[name] == 1 else f"{name} (column {number})"
        for number, name in enumerate(names, 1)
    )
