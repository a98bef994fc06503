"""Blocks of a text log that hold plain numbers alone, read by SciPy's Matrix Market reader.

Such files hold one number per line. The reader is compiled and gives the doubles that ``float``
gives, but it passes over what follows a number on its line and takes lines as cells: a block goes
there only where all of its cells are known to be numbers to their last character.
"""

from collections.abc import Sequence

import numpy as np

from tuner.data.logs.plain import count_rows
from tuner.data.logs.scaling import Floats

_FORM = b"%%%%MatrixMarket matrix array real general\n%d %d\n"
_USUAL, _BEGINNING = b"0123456789.+-eE\n", 1 << 12
_EXACT = 2.0**53
_MINUS, _NEWLINE = b"-\n"


def read_regular(text: bytes, delimiter: bytes, width: int) -> Floats | None:
    """The numbers of whole lines, ``(width, rows)``; None where this reader cannot read them.

    These are lines with other cells than numbers with decimal points, with another number of
    cells, and with whole numbers of which float64 rounds some.

    >>> read_regular(b"1,-2.5\\n3,1e3\\n", b",", 2)
    array([[   1. ,    3. ],
           [  -2.5, 1000. ]])
    >>> read_regular(b"1,-2.5\\n3,1-3\\n", b",", 2)
    """
    rows = count_rows(text, delimiter, width) if _may_be_regular(text, delimiter) else 0
    if not rows:
        return None
    try:
        values = _matrix([_FORM % (width, rows), text.replace(delimiter, b"\n")])
    except ValueError:  # no digit in a cell, or a plus before it
        return None
    except (ImportError, AttributeError, TypeError):  # a SciPy without these private names
        return None
    if values.max() >= _EXACT or values.min() <= -_EXACT:
        return None
    _sign_zeros(values, text, delimiter)
    return values


def _may_be_regular(text: bytes, delimiter: bytes) -> bool:
    """Whether lines may be plain numbers, by their first characters."""
    beginning = text[:_BEGINNING]
    odd = beginning.translate(None, _USUAL + delimiter)
    return not odd and 2 * delimiter not in beginning


class _Stream:
    """Bytes in parts. The requested size is ignored: 1 kB at a time would take a tenth longer."""

    def __init__(self, parts: Sequence[bytes]) -> None:
        self._parts = iter(parts)

    def read(self, size: int = -1) -> bytes:
        """The next part; nothing at the end."""
        return next(self._parts, b"")


def _matrix(parts: Sequence[bytes]) -> Floats:
    """The array of ``scipy.io.mmread`` by one thread, which takes three quarters of the work.

    Raises:
        ValueError: for a line that does not begin with a number, and too few of them.
    """
    from scipy.io import _fast_matrix_market as market

    cursor, _ = market._get_read_cursor(_Stream(parts), 1)
    values: Floats = market._read_body_array(cursor)
    return values


def _sign_zeros(values: Floats, text: bytes, delimiter: bytes) -> None:
    """Give zeros their minus, which the reader adds to a plain zero."""
    zero = values == 0
    if b"-" not in text or not zero.any():
        return
    letters = np.frombuffer(text, np.uint8)
    ends = np.flatnonzero((letters == delimiter[0]) | (letters == _NEWLINE))
    starts = np.append(0, ends[:-1] + 1)
    negative = (letters[starts] == _MINUS).reshape(-1, len(values)).T
    values[zero & negative] = -0.0
