"""A table whose columns do not fit side by side: a block of lines for each of its lines."""

import re
from collections.abc import Iterable, Sequence
from textwrap import wrap

WIDE = 120
"""Columns of a terminal that hold every table; below, the explanations are left out."""
MANY = 6
"""So many columns are hard to read where their cells are half as wide again as the terminal."""
SHORT = 12
"""Letters of a head that stays on one line."""
LONGEST = 28
"""Letters of the longest word that is not broken in a column."""


def longest_word(cells: Iterable[str]) -> int:
    """Letters of the longest word in some cells, up to those that are broken.

    >>> longest_word(["spectral density", "m^2/s^3"])
    8
    """
    return min(max((len(word) for cell in cells for word in cell.split()), default=0), LONGEST)


def crowded(lines: list[list[str]], width: int) -> bool:
    """Whether a narrow terminal breaks the words of a table, or folds the cells of many columns."""
    if width >= WIDE or len(lines[0]) <= 3 or len(lines) < 2:
        return False
    columns = list(zip(*lines, strict=True))
    gaps = 2 * (len(columns) - 1)
    folds = sum(map(_longest_line, columns)) + gaps > 1.5 * width
    return sum(map(_least, columns)) + gaps > width or (len(columns) >= MANY and folds)


def _least(column: Sequence[str]) -> int:
    """Width that breaks no word, and no short head."""
    head, *cells = column
    return max(longest_word([head, *cells]), len(head) if len(head) <= SHORT else 0)


def _longest_line(cells: Iterable[str]) -> int:
    return max(len(part) for cell in cells for part in cell.split("\n"))


def widths(lines: list[list[str]], width: int) -> list[int]:
    """Widths of the columns: their longest words, and what is left by what their lines take more.

    >>> widths([["name", "meaning"], ["q", "a density of so many words"]], 20)
    [4, 14]
    """
    columns = list(zip(*lines, strict=True))
    least = [_least(column) for column in columns]
    more = [_longest_line(column) - word for column, word in zip(columns, least, strict=True)]
    left = max(width - sum(least) - 2 * (len(columns) - 1), 0)
    share = min(left / max(sum(more), 1), 1.0)
    return [word + int(share * extra) for word, extra in zip(least, more, strict=True)]


def broken(text: str, width: int) -> str:
    """A text whose longer words go on in the next line behind a _ or a dot, if they have any.

    >>> print(broken("conventional.time_varying_gains  2", 28))
    conventional.time_varying_
    gains  2
    """
    return re.sub(r"\S+", lambda found: _in_parts(found[0], width), text)


def _in_parts(word: str, width: int) -> str:
    parts = []
    while len(word) > width:
        end = max(word.rfind(mark, 0, width) for mark in "_.") + 1 or width
        parts.append(word[:end])
        word = word[end:]
    return "\n".join([*parts, word])


def blocks(title: str, lines: list[list[str]], width: int) -> str:
    """The table as text: each line's first cell, and below it the others with their heads.

    >>> print(blocks("Inputs", [["name", "unit", "meaning"], ["acc", "m/s^2", ""]], 40))
    Inputs
    acc
      unit     m/s^2
    """
    head, *rows = lines
    longest = max(map(len, head[1:]))
    room = max(width - longest - 4, 20)
    printed = [title]
    for first, *cells in rows:
        printed.append(first)
        for name, cell in zip(head[1:], cells, strict=True):
            parts = [part for line in cell.split("\n") for part in wrap(line, room)]
            starts = [name] + [""] * len(parts)
            printed += [f"  {n:{longest}}  {part}" for n, part in zip(starts, parts, strict=False)]
    return "\n".join(printed)
