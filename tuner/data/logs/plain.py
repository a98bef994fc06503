"""A test whether a text holds only decimal numbers: a bit per character, 64 of them per step.

Which characters are points or delimiters is a bit each; a sum carries from one bit to the next
that matters (Langdale and Lemire 2019).
"""

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.scaling import Bits

_PIECE = 1 << 17  # fits the processor's cache
_NINE, _POINT, _MINUS, _PLUS, _NEWLINE = np.frombuffer(b"9.-+\n", np.uint8)
_E, _SMALL = np.uint8(ord("e")), np.uint8(0x20)
_ONE, _LAST = np.uint64(1), np.uint64(63)

Letters = NDArray[np.uint8]


def count_rows(text: bytes, delimiter: bytes, width: int) -> int:
    """Number of rows of ``width`` numbers in a text; 0 where it holds anything else.

    Numbers are those that ``float`` reads, of digits, points, signs and exponents. Some wrong cells
    pass as numbers: an empty one, a point or a sign alone, a sign before another.

    >>> count_rows(b"1,-2.5\\n3,1e3\\n", b",", 2), count_rows(b"1,2.5.6\\n", b",", 2)
    (2, 0)
    """
    if b"/" in text:  # the one character between the point and the digits
        return 0
    letters = np.frombuffer(text, np.uint8)
    bits = np.zeros((4, -(-len(letters) // 64)), np.uint64)
    plus, exponents = b"+" in text, b"e" in text or b"E" in text
    for start in range(0, len(letters), _PIECE):
        piece = letters[start : start + _PIECE + 1]
        found = bits.view(np.uint8)[:, start // 8 :]
        if not _mark(piece, delimiter, plus, exponents, found):
            return 0
    points, raised, borders, lines = bits
    between = ~(points | raised | borders)
    twice = _reached(points, between) & points
    if exponents:
        twice |= _reached(raised, between) & (raised | points)
    return 0 if twice.any() else _even_rows(borders, lines, width)


def _mark(piece: Letters, delimiter: bytes, plus: bool, exponents: bool, found: Letters) -> bool:
    """Set the bits of points, exponents, borders and ends of lines; False for what is no number."""
    digit = piece - _POINT <= _NINE - _POINT
    sign = piece == _MINUS
    if plus:
        sign |= piece == _PLUS
    line = piece == _NEWLINE
    border = line | (piece == delimiter[0])
    known = digit | sign
    wrong = sign[1:] & digit[:-1]
    if exponents:
        raised = piece | _SMALL == _E
        wrong |= sign[1:] & sign[:-1]
        wrong |= ~known[1:] & ~digit[:-1]
        known |= raised
        _pack(raised, found[1])
    known |= border
    _pack(piece == _POINT, found[0])
    _pack(border, found[2])
    _pack(line, found[3])
    return bool(known.all()) and not wrong.any()


def _pack(flags: NDArray[np.bool_], found: Letters) -> None:
    packed = np.packbits(flags[:_PIECE], bitorder="little")
    found[: len(packed)] = packed


def _reached(bits: Bits, between: Bits) -> Bits:
    """The first places behind some bits that are not between; all where one is over 64 away."""
    starts = bits << _ONE
    starts[1:] |= bits[:-1] >> _LAST
    ends = starts + between
    carried = (ends < starts)[:-1]
    ends[1:] += carried
    if (carried & (ends[1:] == 0)).any():
        return ~np.zeros_like(ends)
    return ends & ~between


def _even_rows(borders: Bits, lines: Bits, width: int) -> int:
    """The number of lines where each has ``width`` borders; else 0."""
    counts = np.bitwise_count(borders).astype(np.intp)
    before = np.cumsum(counts) - counts
    rows, places = 0, np.flatnonzero(lines)
    left = lines[places]
    while len(left):  # the first line that ends in each word, then the second, ...
        first = left & -left
        rank = before[places] + np.bitwise_count(borders[places] & (first - _ONE))
        if ((rank + 1) % width).any():
            return 0
        rows += len(left)
        left ^= first
        places, left = places[left != 0], left[left != 0]
    return rows if rows * width == counts.sum() else 0
