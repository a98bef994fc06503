"""Blocks of plain numbers, read by C that this machine's compiler has compiled.

It gives the bits of :func:`read_regular`, to which it leaves what it cannot round with certainty,
in a third of the time and without the interpreter's lock. Where there is no compiler that works,
or the log is too short for it to pay, ``read_regular`` reads all.
"""

import ctypes
import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from tuner.cached import code_folder
from tuner.data.logs.regular import read_regular
from tuner.data.logs.scaling import Floats
from tuner.native.compiler import NoCodeError, library, use

Reader: TypeAlias = Callable[[bytes, bytes, int], Floats | None]
"""From whole lines, their delimiter and the number of their cells to numbers, ``(width, rows)``;
None for what are no plain numbers."""

PAYS = 8 << 20
"""Bytes of a log from which it is read by C."""
_PATIENCE = 2.0
_FOUND, _NOT_PLAIN = 0, 1
_LOWEST_POWER = -290
_NEWLINE = ord("\n")
_KNOWN = "0,-0.1,.3,5.,1e5,-2.5E-3,0.1234567890123456789,1e-200,9007199254740991,123.456e+2"


def plain_reader(size: int) -> Reader:
    """The reader of a log's blocks of plain numbers; ``TUNER_NATIVE`` chooses, as for gradients.

    Args:
        size: bytes of the log.

    Raises:
        ValueError: for another word in ``TUNER_NATIVE`` than auto, on and off.
    """
    wish = use()
    if wish == "off" or (wish == "auto" and size < PAYS):
        return read_regular
    try:
        return _begun(os.environ.get("CC")).result(_PATIENCE)
    except (NoCodeError, OSError, AttributeError, RuntimeError, TimeoutError):
        return read_regular


@cache
def _begun(program: str | None) -> Future[Reader]:
    """C of a compiler, or the reason why there is none; nobody waits long for a slow one."""
    pool = ThreadPoolExecutor(1)
    future = pool.submit(compiled)
    pool.shutdown(wait=False)
    return future


def compiled() -> Reader:
    """The reader in C.

    Raises:
        NoCodeError: where there is no compiler that works.
    """
    source = Path(__file__).with_name("plain.c").read_text("ascii")
    function = library(source, code_folder()).read_numbers
    function.argtypes = [
        ctypes.c_char_p,
        ctypes.c_size_t,
        ctypes.c_int,
        ctypes.c_size_t,
        ctypes.c_size_t,
        ctypes.c_void_p,
        ctypes.c_void_p,
    ]
    function.restype = ctypes.c_int
    tens = powers_of_ten()

    def read(text: bytes, delimiter: bytes, width: int) -> Floats | None:
        rows = int(np.count_nonzero(np.frombuffer(text, np.uint8) == _NEWLINE))
        if not 0 < 2 * rows * width <= len(text):  # a cell is a digit and a border at least
            return None
        values = np.empty((width, rows))
        given = len(text), delimiter[0], rows, width, tens.ctypes.data, values.ctypes.data
        status = function(text, *given)
        if status in (_FOUND, _NOT_PLAIN):
            return values if status == _FOUND else None
        return read_regular(text, delimiter, width)

    _check(read)
    return read


def powers_of_ten() -> np.ndarray[Any, Any]:
    """10^-290 to 10^-1: 128 leading bits, cut off, in two parts, and the exponent of two."""
    rows = []
    for power in range(-_LOWEST_POWER, 0, -1):
        below = 10**power
        exponent = 127 + below.bit_length()
        bits = (1 << exponent) // below
        if bits >> 128:
            exponent, bits = exponent - 1, bits >> 1
        rows.append((bits >> 64, bits & ((1 << 64) - 1), (1 << 64) - exponent))
    return np.array(rows, np.uint64)


def _check(read: Reader) -> None:
    """Refuse a reader that gives other bits than Python, as options for fast arithmetic may."""
    cells = _KNOWN.split(",")
    found = read(_KNOWN.encode() + b"\n", b",", len(cells))
    if found is None or found.tobytes() != np.array([float(cell) for cell in cells]).tobytes():
        raise NoCodeError("compiled C reads numbers that Python reads differently")
