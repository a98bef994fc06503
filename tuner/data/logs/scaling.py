"""Whole numbers times powers of ten as the nearest doubles, many at once.

Up to 2**53 and 10**22 one rounding of an exact quotient is right (Clinger 1990); beyond, the
product with a power of ten is computed in twice the digits (Dekker 1971).
"""

from fractions import Fraction
from functools import cache

import numpy as np
from numpy.typing import NDArray

Index = NDArray[np.intp]
Bits = NDArray[np.uint64]
Floats = NDArray[np.float64]

_EXACT = np.uint64(1 << 53)
_FIVES = 22
_LARGEST = 280
_SHARE = 0.2
_SPLIT = 134217729.0  # 2**27 + 1
_DOUBT = 2.0**-99
_POWERS = np.array([10.0**k for k in range(_FIVES + 1)])


def scaled(whole: Bits, power: Index, odd: NDArray[np.bool_]) -> Floats:
    """Integers times powers of ten; those not certain to the last bit are marked odd."""
    power[odd] = 0
    hard = (whole > _EXACT) | (np.abs(power) > _FIVES)
    share = hard.sum() / max(len(hard), 1)
    if share == 0.0:
        return _once_rounded(whole, power)
    if share > _SHARE:
        values, sure = _product(whole, power)
        odd |= ~sure
        return values
    few = np.flatnonzero(hard)
    values, sure = _product(whole[few], power[few])
    odd[few] |= ~sure
    power[few] = 0
    found = _once_rounded(whole, power)
    found[few] = values
    return found


def _once_rounded(whole: Bits, power: Index) -> Floats:
    values = whole.astype(np.float64)
    low, high = int(power.min(initial=0)), int(power.max(initial=0))
    if high > 0:
        values *= _POWERS.take(np.maximum(power, 0))
    if low < 0:
        values /= _POWERS.take(np.maximum(-power, 0))
    return values


def _product(whole: Bits, power: Index) -> tuple[Floats, NDArray[np.bool_]]:
    """The nearest doubles, and whether they surely are."""
    inside = np.abs(power) <= _LARGEST
    place = np.where(inside, power, 0) + _LARGEST
    tens, rest_of_tens = (table.take(place) for table in _tens())
    head = whole.astype(np.float64)
    rest = (whole - head.astype(np.uint64)).view(np.int64).astype(np.float64)
    product = head * tens
    error = _error_of_product(head, tens, product) + (head * rest_of_tens + rest * tens)
    value = product + error
    left = error - (value - product)
    doubt = value * _DOUBT
    sure = (value + (left + doubt) == value) & (value + (left - doubt) == value)
    return value, sure & inside


def _error_of_product(a: Floats, b: Floats, product: Floats) -> Floats:
    """The rounding error of a product (Dekker 1971)."""
    a_high, b_high = a * _SPLIT, b * _SPLIT
    a_high -= a_high - a
    b_high -= b_high - b
    a_low, b_low = a - a_high, b - b_high
    error: Floats = a_low * b_low - (
        ((product - a_high * b_high) - a_low * b_high) - a_high * b_low
    )
    return error


@cache
def _tens() -> tuple[Floats, Floats]:
    """Powers of ten as sums of two doubles, the second the remainder of the first."""
    exact = [Fraction(10) ** k for k in range(-_LARGEST, _LARGEST + 1)]
    high = [float(value) for value in exact]
    low = [float(value - Fraction(part)) for value, part in zip(exact, high, strict=True)]
    return np.array(high), np.array(low)
