"""Blocks of numbers, read by C that this machine's compiler has compiled.

It gives the bits of all other readers, to which it leaves what it cannot round with certainty, in a
third of the time and without the interpreter's lock. Where there is no compiler that works, or the
log is too short for it to pay, blocks of plain numbers are read by SciPy.
"""

import ctypes
import os
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tuner.cached import code_folder
from tuner.compiler import NoCodeError, library, use
from tuner.data.logs.regular import read_regular
from tuner.data.logs.scaling import Bits, Floats


@dataclass(frozen=True)
class Form:
    """How lines of numbers are written, and which of their columns are wanted.

    Attributes:
        delimiter: one character; a blank stands for any number of them.
        point: the decimal mark.
        width: number of cells in a line.
        columns: the wanted ones.
    """

    delimiter: bytes
    point: bytes
    width: int
    columns: Sequence[int]


Reader: TypeAlias = Callable[[bytes, Form], Sequence[Floats] | None]
"""From whole lines to the wanted columns; None for lines that it cannot read."""

PAYS = 8 << 20
"""Bytes of a log from which it is read by C."""
_PATIENCE = 2.0
_FOUND, _NOT_PLAIN = 0, 1
_LOWEST_POWER = -290
_NEWLINE = ord("\n")
_KNOWN = "0,-0.1,.3,5.,+1e5, -2.5E-3 ,0.1234567890123456789,1e-200,9007199254740991,12.5e+2,nan"


class _Form(ctypes.Structure):
    """The same in C."""

    _fields_ = (
        ("rows", ctypes.c_size_t),
        ("width", ctypes.c_size_t),
        ("place", ctypes.c_void_p),
        ("delimiter", ctypes.c_int),
        ("point", ctypes.c_int),
    )


def reader(size: int) -> Reader:
    """The reader of a log's blocks; ``TUNER_NATIVE`` chooses, as for gradients.

    Args:
        size: bytes of the log.

    Raises:
        ValueError: for another word in ``TUNER_NATIVE`` than auto, on and off.
    """
    wish = use()
    if wish == "off" or (wish == "auto" and size < PAYS):
        return by_scipy
    try:
        return _begun(os.environ.get("CC")).result(_PATIENCE)
    except (NoCodeError, OSError, AttributeError, RuntimeError, TimeoutError):
        return by_scipy


def by_scipy(text: bytes, form: Form) -> Sequence[Floats] | None:
    """Blocks of plain numbers alone, most columns of which are wanted."""
    if form.point != b"." or 2 * len(form.columns) < form.width:
        return None
    values = read_regular(text, form.delimiter, form.width)
    return None if values is None else [values[k] for k in form.columns]


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
    address = ctypes.c_void_p
    function.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.POINTER(_Form), address, address]
    function.restype = ctypes.c_int
    tens = powers_of_ten()

    def read(text: bytes, form: Form) -> Sequence[Floats] | None:
        rows = int(np.count_nonzero(np.frombuffer(text, np.uint8) == _NEWLINE))
        if not 0 < rows * form.width <= len(text):  # each cell has a border
            return None
        place = places(form)
        values = np.empty((len(form.columns), rows))
        layout = _Form(rows, form.width, place.ctypes.data, form.delimiter[0], form.point[0])
        status = function(text, len(text), layout, tens.ctypes.data, values.ctypes.data)
        if status in (_FOUND, _NOT_PLAIN):
            return list(values) if status == _FOUND else None
        return by_scipy(text, form)

    _check(read)
    return read


def places(form: Form) -> NDArray[np.int64]:
    """The place of each column of a text among the wanted ones, ``(width,)``; -1 for others."""
    place = np.full(form.width, -1, np.int64)
    place[list(form.columns)] = np.arange(len(form.columns))
    return place


def powers_of_ten() -> Bits:
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
    found = read(_KNOWN.encode() + b"\n", Form(b",", b".", len(cells), range(len(cells))))
    right = np.array([float(cell) for cell in cells])
    if found is None or np.array(found).tobytes() != right.tobytes():
        raise NoCodeError("compiled C reads numbers that Python reads differently")
