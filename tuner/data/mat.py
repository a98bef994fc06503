"""Reading MAT v5 within bounds: on a damaged file scipy's reader can end the whole process.

Format: MathWorks, MAT-File Format (R2019b), chapter 1.
"""

import math
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tuner.limits import largest, unpacked

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_CELL, _STRUCT, _OBJECT, _CHAR, _OPAQUE = 1, 2, 3, 4, 17  # classes of matrices
_COMPLEX, _LOGICAL = 0x08, 0x02
_VALUE = 1 << 9  # bytes that any value takes in memory, however small it is
_DEEPEST = 24
_PIECE = 1 << 14
# MATLAB packs the numbers of a matrix into the smallest of these that holds them.
_NUMBERS = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8",
}  # fmt: skip
_CLASSES = {
    6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8", 15: "u8",
}  # fmt: skip
_TEXTS = {1: "latin-1", 2: "latin-1", 4: "utf-16-native", 16: "utf-8", 17: "utf-16-native"}

Numbers: TypeAlias = NDArray[Any]
Bytes: TypeAlias = bytes | memoryview
Parts: TypeAlias = list[tuple[int, Bytes]]


@dataclass(frozen=True)
class Opaque:
    """An object of a MATLAB class, such as a timetable.

    Attributes:
        kind: its class.
        reference: where the file keeps its properties.
    """

    kind: str
    reference: Any


@dataclass(frozen=True)
class Structs:
    """A struct array, ``(1, 1)`` as a rule.

    Attributes:
        shape: of the array.
        fields: the values of each field, in MATLAB's order.
    """

    shape: tuple[int, ...]
    fields: dict[str, "list[Value]"]


@dataclass(frozen=True)
class Cells:
    """A cell array: its values in MATLAB's order."""

    shape: tuple[int, ...]
    values: "list[Value]"


Value: TypeAlias = Numbers | str | Structs | Cells | Opaque | None


class Layout:
    """The byte order of a file, and the memory that it may still take.

    Args:
        order: byte order, "<" or ">".
        budget: bytes that all of its values together may take.
    """

    def __init__(self, order: str, budget: int) -> None:
        self.order = order
        self._budget = budget

    def take(self, size: int) -> None:
        """Take some of the budget.

        Raises:
            ValueError: where there is none left.
        """
        self._budget -= size + _VALUE
        if self._budget < 0:
            raise ValueError("it would unpack to more than a hundredfold, or than fits in memory")


def read(data: Bytes) -> dict[str, Value]:
    """The variables of a MAT v5 file; sparse matrices and functions are None.

    Raises:
        ValueError: one sentence, where the file is damaged or of another kind, or would unpack
            to more than :func:`tuner.limits.unpacked` and :func:`tuner.limits.largest` allow.
        struct.error: where a size in it cannot be read.
        zlib.error: where a compressed variable is damaged.
    """
    order = {b"IM": "<", b"MI": ">"}.get(bytes(data[_HEADER - 2 : _HEADER]))
    if order is None:
        raise ValueError("it has no header of a MAT v5 file")
    budget = min(unpacked(len(data)), largest())
    layout = Layout(order, budget)
    bodies = _variables(memoryview(data)[_HEADER:], order, budget)
    return dict(_value(body, layout, _DEEPEST) for body in bodies)


def variables(data: bytes) -> tuple[dict[str, NDArray[np.float64]], dict[str, str]]:
    """The matrices and texts of a MAT v5 file; what is neither double nor byte is skipped.

    Raises:
        ValueError: one sentence, where the file is damaged or of another kind.
        struct.error: where a size in it cannot be read.
        zlib.error: where a compressed variable is damaged.
    """
    found = read(data)
    matrices = {
        name: value.astype(np.float64)
        for name, value in found.items()
        if isinstance(value, np.ndarray) and value.dtype in (np.float64, np.uint8, np.bool_)
    }
    return matrices, {name: text for name, text in found.items() if isinstance(text, str)}


def elements(data: bytes, order: str) -> Iterator[Value]:
    """The values of consecutive matrices, without a header.

    Raises:
        ValueError: one sentence, where they are damaged.
        struct.error: where a size cannot be read.
    """
    layout = Layout(order, min(unpacked(len(data)), largest()))
    for kind, body in _elements(data, order):
        if kind == _MATRIX:
            yield _value(body, layout, _DEEPEST)[1]


def _variables(data: Bytes, order: str, budget: int) -> Iterator[Bytes]:
    """The bodies of the variables, compressed ones unpacked."""
    for kind, body in _elements(data, order):
        if kind == _COMPRESSED:
            unpacked = _unpacked(body, budget)
            budget -= len(unpacked)
            yield from (inner for kind, inner in _elements(unpacked, order) if kind == _MATRIX)
        elif kind == _MATRIX:
            yield body


def _unpacked(body: Bytes, budget: int) -> memoryview:
    """The bytes of a compressed variable, piece by piece so that they are in memory once."""
    unpacker, out = zlib.decompressobj(), bytearray()
    for at in range(0, len(body), _PIECE):
        out += unpacker.decompress(body[at : at + _PIECE])
        if len(out) > budget:
            raise ValueError("it would unpack to more than a hundredfold, or than fits in memory")
    if not unpacker.eof:
        raise ValueError("it ends too early")
    return memoryview(out)


def _elements(data: Bytes, order: str) -> Iterator[tuple[int, Bytes]]:
    """Consecutive elements: the type and the bytes of each."""
    at = 0
    while at < len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        at += 8
        if kind >> 16:  # a small element: size and type share four bytes, the data have the rest
            kind, size, at = kind & 0xFFFF, kind >> 16, at - 4
        body = data[at : at + size]
        if len(body) != size:
            raise ValueError("it ends too early")
        yield kind, body
        at += size
        if kind != _COMPRESSED:
            at += -at % 8


def _value(body: Bytes, layout: Layout, deep: int) -> tuple[str, Value]:
    """The name and the value of a matrix."""
    if not body:
        return "", np.empty((0, 0))
    if deep == 0:
        raise ValueError(f"it is nested more than {_DEEPEST} deep")
    (_, flags), (_, second), (_, third), *rest = _elements(body, layout.order)
    word = struct.unpack_from(f"{layout.order}I", flags)[0]
    kind, marks = word & 0xFF, word >> 8 & 0xFF
    if kind == _OPAQUE:  # it has no sizes: its name and the kind of system come next
        (_, class_name), *held = rest
        inner = _value(held[0][1], layout, deep - 1)[1] if held and held[0][0] == _MATRIX else None
        return _letters(second), Opaque(_letters(class_name), inner)
    layout.take(0)
    shape = _shape(second, layout.order)
    return _letters(third), _of_class(kind, marks, shape, rest, layout, deep)


def _of_class(
    kind: int, marks: int, shape: tuple[int, ...], rest: Parts, layout: Layout, deep: int
) -> Value:
    """The value of a matrix of some class; None for one that is skipped."""
    if kind in _CLASSES:
        return _matrix(shape, rest, layout, kind, marks)
    if kind == _CHAR:
        return _text(rest, layout.order)
    if kind in (_STRUCT, _OBJECT):
        return _structs(shape, rest[kind == _OBJECT :], layout, deep)
    if kind == _CELL:
        return Cells(shape, [_value(part, layout, deep - 1)[1] for _, part in rest])
    return None


def _letters(name: Bytes) -> str:
    return bytes(name).decode("latin-1")


def _shape(sizes: Bytes, order: str) -> tuple[int, ...]:
    shape = np.frombuffer(sizes, f"{order}i4").tolist()
    if min(shape, default=0) < 0 or len(shape) > 32:
        raise ValueError("it holds a matrix of an impossible size")
    return tuple(shape)


def _matrix(shape: tuple[int, ...], rest: Parts, layout: Layout, kind: int, marks: int) -> Numbers:
    parts = []
    for stored, body in rest[:2]:
        if stored not in _NUMBERS:
            raise ValueError("it holds a matrix that is not of numbers")
        parts.append(np.frombuffer(body, layout.order + _NUMBERS[stored]))
    if len(parts) != 1 + bool(marks & _COMPLEX):
        raise ValueError("it holds a matrix that is not of real numbers")
    if any(math.prod(shape) != part.size for part in parts):
        raise ValueError("it holds a matrix with too many or too few numbers")
    dtype = "?" if marks & _LOGICAL else _CLASSES[kind]
    layout.take(math.prod(shape) * np.dtype(dtype).itemsize * len(parts))
    numbers = parts[0].astype(dtype, copy=False) if len(parts) == 1 else parts[0] + 1j * parts[1]
    return numbers.reshape(shape, order="F")


def _text(rest: Parts, order: str) -> str:
    if len(rest) != 1 or rest[0][0] not in _TEXTS:
        raise ValueError("it holds a text of an unknown kind")
    kind, body = rest[0]
    letters = _TEXTS[kind].replace("native", {"<": "le", ">": "be"}[order])
    return bytes(body).decode(letters, errors="replace")


def _structs(shape: tuple[int, ...], rest: Parts, layout: Layout, deep: int) -> Structs:
    """The fields of a struct array, whose values stand element by element."""
    (_, length), (_, letters), *values = rest
    (width,) = struct.unpack_from(f"{layout.order}i", length)
    if width < 1 or len(letters) % width:
        raise ValueError("it holds a struct whose names of fields do not fit")
    letters = bytes(letters)
    names = [
        _letters(letters[i : i + width].partition(b"\0")[0]) for i in range(0, len(letters), width)
    ]
    if len(values) != len(names) * math.prod(shape):
        raise ValueError("it holds a struct with too many or too few values")
    parts = [_value(body, layout, deep - 1)[1] for _, body in values]
    return Structs(shape, {name: parts[k :: len(names)] for k, name in enumerate(names)})
