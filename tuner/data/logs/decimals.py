"""Decimal numbers in a text as float64, many at once: the very doubles that ``float`` gives.

Up to 19 digits are one 64-bit integer, eight characters per step. Up to 2**53 and 10**22 one
rounding of an exact quotient is right (Clinger 1990); beyond, the product with a power of ten is
computed in twice the digits (Dekker 1971), and where that leaves the last bit open, or where a
cell is written in another way, the number is left to others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.scaling import Bits, Floats, Index, scaled

MARGIN = 24
"""Characters before a text that may be read; so may eight after it."""

_DIGITS, _SINGLY = 19, 3
_POWERS = 10.0 ** np.arange(9)
_TENS = np.array([10**k for k in range(_DIGITS + 1)], np.uint64)
_OUTSIDE = np.array([8 * (8 - k) for k in range(9)], np.uint64)
_ZEROS, _ABOVE_9, _TOP = (np.uint64(word * 0x0101010101010101) for word in (ord("0"), 0x76, 0x80))
_PAIRS = [  # digits to pairs, pairs to fours, fours to all eight
    tuple(map(np.uint64, step))
    for step in (
        (10 * 2**8 + 1, 8, 0x00FF00FF00FF00FF),
        (100 * 2**16 + 1, 16, 0x0000FFFF0000FFFF),
        (10000 * 2**32 + 1, 32, 0x00000000FFFFFFFF),
    )
]


@dataclass(frozen=True, eq=False)
class Spans:
    """Places of numbers in a text: indices of characters, ``(N,)`` each.

    Attributes:
        starts: of the first character.
        points: of the decimal point; where there is none, of what follows the digits.
        stops: behind the last digit before an exponent.
        ends: behind the last character.
        odd: cells that may be no such number, ``(N,)``.
    """

    starts: Index
    points: Index
    stops: Index
    ends: Index
    odd: NDArray[np.bool_]

    def shaped(self, width: int) -> "Spans":
        """In rows of ``width``."""
        return self._each(lambda part: part.reshape(-1, width))

    def columns(self, columns: Sequence[int]) -> "Spans":
        """Some columns of rows, one row after another, flat."""
        every = list(columns) == list(range(self.starts.shape[1]))
        return self._each(lambda part: (part if every else part[:, list(columns)]).ravel())

    def _each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> "Spans":
        parts = (self.starts, self.points, self.stops, self.ends, self.odd)
        return Spans(*map(change, parts))


@dataclass(frozen=True, eq=False)
class Numbers:
    """The numbers that were read.

    Attributes:
        values: ``(N,)``; NaN where there is none.
        whole: the digits as one integer, without a sign, ``(N,)``.
        negative: where a minus stands, ``(N,)``.
        odd: the indices of cells that have to be read in another way.
    """

    values: Floats
    whole: Bits
    negative: NDArray[np.bool_]
    odd: Index


def read_decimals(text: NDArray[np.uint8], spans: Spans) -> Numbers:
    """Read the numbers of a text that has ``MARGIN`` characters before the first.

    >>> text = np.frombuffer(b"0" * MARGIN + b"-12.50" + b"0" * 10, np.uint8)
    >>> at = (np.array([MARGIN + k]) for k in (0, 3, 6, 6))
    >>> read_decimals(text, Spans(*at, np.array([False]))).values
    array([-12.5])
    """
    words = text.view(np.uint64)
    first = text.take(spans.starts)
    negative = first == ord("-")
    starts = spans.starts + (negative | (first == ord("+"))).astype(np.intp)
    pointed = (spans.points < spans.stops).astype(np.intp)
    before = spans.points - starts
    behind = spans.stops - spans.points
    behind -= pointed
    length = spans.stops - starts
    odd = spans.odd | (length <= pointed) | (length > _DIGITS + pointed)
    if odd.any():
        before[odd] = 0
        behind[odd] = 0
    wrong = np.zeros(len(starts), np.uint64)
    plain = spans.stops is spans.ends or bool((spans.stops == spans.ends).all())
    if length.max(initial=0) <= 8:
        whole = _at_once(words, spans.stops, before, pointed, behind, wrong)
        values = _quotients(whole, behind) if plain else np.empty(0)
    else:
        whole = _integers(words, spans.points, before, wrong)
        whole *= _TENS.take(behind)
        whole += _integers(words, spans.stops, behind, wrong)
        values = np.empty(0)
    wrong &= _TOP
    odd |= wrong != 0
    if not len(values):
        power = -behind
        if not plain:
            _raise(text, spans, power, odd)
        values = scaled(whole, power, odd)
    np.negative(values, where=negative, out=values)
    empty = spans.starts == spans.ends
    if empty.any():
        values[empty] = np.nan
        odd &= ~empty
    return Numbers(values, whole, negative, np.flatnonzero(odd))


def _quotients(whole: Bits, behind: Index) -> Floats:
    """Numbers with few digits and a small divisor: one rounding."""
    values = whole.astype(np.float64)
    values /= _POWERS.take(behind)
    return values


def _at_once(
    words: Bits, ends: Index, before: Index, pointed: Index, behind: Index, wrong: Bits
) -> Bits:
    """The digits of numbers of eight characters at most, the point taken out."""
    found = _word(words, ends - 8)
    outside = _OUTSIDE.take(behind)
    part = found >> outside
    part <<= outside
    found <<= ((behind + pointed) << 3).view(np.uint64)
    outside = _OUTSIDE.take(before)
    found >>= outside
    found <<= outside
    found >>= (behind << 3).view(np.uint64)
    found |= part
    return _value(found, wrong)


def _integers(words: Bits, ends: Index, count: Index, wrong: Bits) -> Bits:
    """The numbers of ``count`` digits before ``ends``; a top bit of ``wrong`` is set where not."""
    longest = int(count.max(initial=0))
    total = _part(words, ends, np.minimum(count, 8), min(longest, 8), wrong)
    for step in range(8, longest, 8):
        most = min(longest - step, 8)
        part = np.clip(count - step, 0, 8)
        total += _part(words, ends - step, part, most, wrong) * _TENS[step]
    return total


def _part(words: Bits, ends: Index, count: Index, most: int, wrong: Bits) -> Bits:
    """The numbers of ``count`` digits before ``ends``, ``most`` of 8 at most."""
    if most > _SINGLY:
        found = _word(words, ends - 8)
        outside = _OUTSIDE.take(count)
        found >>= outside
        found <<= outside
        return _value(found, wrong)
    text, total = words.view(np.uint8), np.zeros(len(ends), np.uint64)
    for k in range(most):
        digit = text.take(ends - (k + 1)) ^ np.uint8(ord("0"))
        digit *= count > k
        total += digit * _TENS[k]
        wrong |= (digit > 9) * _TOP
    return total


def _word(words: Bits, starts: Index) -> Bits:
    """Eight characters from ``starts`` on, digits by their values."""
    at, shift = starts >> 3, ((starts & 7) << 3).view(np.uint64)
    found = words.take(at)
    found >>= shift
    shift = np.uint64(64) - shift
    at += 1
    following = words.take(at)
    following <<= shift
    found |= following
    found ^= _ZEROS
    return found


def _value(found: Bits, wrong: Bits) -> Bits:
    """The number of eight digits."""
    wrong |= found
    wrong |= found + _ABOVE_9
    for factor, shift, mask in _PAIRS:
        found *= factor
        found >>= shift
        found &= mask
    return found


def _raise(text: NDArray[np.uint8], spans: Spans, power: Index, odd: NDArray[np.bool_]) -> None:
    """Add the number of each exponent to the powers."""
    raised = np.flatnonzero(spans.stops < spans.ends)
    found, failed = _exponents(text, spans.stops[raised] + 1, spans.ends[raised])
    power[raised] += found
    odd[raised] |= failed


def _exponents(
    text: NDArray[np.uint8], starts: Index, ends: Index
) -> tuple[Index, NDArray[np.bool_]]:
    """Small whole numbers with or without a sign, and which are none."""
    sign = text.take(starts)
    minus = sign == ord("-")
    count = ends - starts - (minus | (sign == ord("+")))
    odd = (count < 1) | (count > 3)
    count[odd] = 0
    wrong = np.zeros(len(starts), np.uint64)
    found = _integers(text.view(np.uint64), ends, count, wrong).astype(np.intp)
    return np.where(minus, -found, found), odd | (wrong & _TOP != 0)
