"""Rows of several kinds in one text log, marked by a word: ``IMU,...`` and ``GPS,...``."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tuner.data.logs.cells import is_missing, is_number
from tuner.data.logs.moments import is_moment
from tuner.data.logs.stream import Encoding, is_content, lines, split

_FIRST = 3
_MOST = 60
_SAMPLE = 300
_SHARE = 0.9


@dataclass(frozen=True)
class Chosen:
    """The rows of one kind.

    Attributes:
        column: the column of its word, from 0.
        word: the word.
    """

    column: int
    word: str

    def holds(self, cells: Sequence[str]) -> bool:
        """Whether a row is of this kind."""
        return len(cells) > self.column and cells[self.column].strip() == self.word


@dataclass(frozen=True, eq=False)
class Lines:
    """Some lines of a file with content: their numbers, from 0, and what they hold."""

    numbers: list[int]
    texts: list[str]


def kinds_of(path: Path, encoding: Encoding, delimiter: str, first: Lines) -> dict[Chosen, Lines]:
    """The kinds of rows with the first lines of each; empty where all rows are of one.

    Rows are of several kinds where one of their first cells is a word in all of them, which
    determines the number of cells.
    """
    rows = list(split(first.texts[len(first.texts) // 2 :], delimiter))
    for column in range(_FIRST):
        if rows and all(_is_word(row, column) for row in rows):
            found, widths = _by_word(path, encoding, delimiter, column)
            if _tells_width(widths):
                return {Chosen(column, word): part for word, part in found.items()}
    return {}


def _is_word(row: Sequence[str], column: int) -> bool:
    cell = row[column] if len(row) > column else ""
    return not (is_missing(cell) or is_number(cell) or is_moment(cell))


def _by_word(
    path: Path, encoding: Encoding, delimiter: str, column: int
) -> tuple[dict[str, Lines], dict[str, Counter[int]]]:
    """The first lines with each word in a column, and how many cells those lines have."""
    found: dict[str, Lines] = {}
    widths: dict[str, Counter[int]] = {}
    number = -1
    for block in lines(path, encoding):
        for line in block.decode(encoding.letters, "replace").removesuffix("\n").split("\n"):
            number += 1
            cells = line.split(delimiter, column + 1)
            if len(cells) < column + 2 or not is_content(line):
                continue
            word = cells[column].strip().strip('"')
            part = found.setdefault(word, Lines([], []))
            if len(part.texts) < _SAMPLE:
                part.numbers.append(number)
                part.texts.append(line)
            widths.setdefault(word, Counter())[line.count(delimiter) + 1] += 1
        if len(found) > _MOST:
            return {}, {}
    return found, widths


def _tells_width(widths: dict[str, Counter[int]]) -> bool:
    """Whether there are several widths, and each word has nearly always the same one."""
    usual = {word: count.most_common(1)[0] for word, count in widths.items()}
    rows = sum(sum(count.values()) for count in widths.values())
    repeated = {width for word, (width, times) in usual.items() if times > 1}
    return len(repeated) > 1 and sum(times for _, times in usual.values()) >= _SHARE * rows
