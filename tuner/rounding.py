"""Numbers in a few digits."""

from decimal import ROUND_CEILING, ROUND_FLOOR, Context


def outward(
    low: float | None, high: float | None, digits: int = 3
) -> tuple[float | None, float | None]:
    """The ends of an interval in a few digits, which contain all that the interval does.

    Args:
        low, high: the ends; None where there is none.
        digits: how many digits are kept.

    >>> outward(0.010525, 0.011029), outward(1.0, 2.5), outward(-0.0123456, None)
    ((0.0105, 0.0111), (1.0, 2.5), (-0.0124, None))
    """
    return _rounded(low, digits, ROUND_FLOOR), _rounded(high, digits, ROUND_CEILING)


def _rounded(value: float | None, digits: int, towards: str) -> float | None:
    if value is None:
        return None
    # Rounding errors of the last digits of a float are no reason to give the next number.
    near = Context(prec=12).create_decimal(repr(float(value)))
    return float(Context(prec=digits, rounding=towards).create_decimal(near))
